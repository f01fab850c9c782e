"""The commands, one a file in `magbench.commands`, and what becomes of their errors."""

from __future__ import annotations

import os
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from functools import cache
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperOption

import magbench
from magbench.api.inputs import in_options
from magbench.commands import (
    apply,
    bound,
    calibrate,
    compare,
    diagnose,
    gate,
    inspect,
    listing,
    plan,
    read,
    recheck,
    reproduce,
    run,
    schema,
    show,
    simulate,
)
from magbench.refusal import refuse
from scenarios.errors import InputError

EPILOG = (
    "Exit status: 0 done, 1 a gate failed, a gap was found and not explained, or a calibration is not found valid, "
    "2 wrong use or bad input (one line says what, where and what to do)."
)


HELP_WIDTH = 120
"""Columns of a help text at most, where the terminal is wider."""
WRAPPED = "Value error, "
"""What typer puts before the message of a choice."""


class SingleValueCommand(TyperCommand):
    """A command that refuses a repeated option of a single value; otherwise the last value would win silently."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """As every command does; raises InputError."""
        _, _, order = self.make_parser(ctx).parse_args(args=list(args))
        for option, times in Counter(order).items():
            single = isinstance(option, TyperOption) and not (option.multiple or option.is_flag)
            if single and times > 1 and not ctx.resilient_parsing:
                raise InputError(f"takes one value, and {times} are given", where=option.opts[0], do="give it once")
        return super().parse_args(ctx, args)


app = typer.Typer(
    name="magbench",
    epilog=EPILOG,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"max_content_width": HELP_WIDTH},
)
COMMANDS: dict[str, Callable[..., None]] = {
    "run": run.command,
    "simulate": simulate.command,
    "compare": compare.command,
    "gate": gate.command,
    "read": read.command,
    "recheck": recheck.command,
    "calibrate": calibrate.command,
    "apply": apply.command,
    "inspect": inspect.command,
    "diagnose": diagnose.command,
    "bound": bound.command,
    "plan": plan.command,
    "reproduce": reproduce.command,
    "show": show.command,
    "list": listing.command,
    "schema": schema.command,
}
for name, command in COMMANDS.items():
    app.command(name, cls=SingleValueCommand)(command)


def _say_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"magbench {magbench.__version__}")
        raise typer.Exit()


@app.callback()
def magbench_(
    version: Annotated[
        bool, typer.Option("--version", help="Show the version.", callback=_say_version, is_eager=True)
    ] = False,
) -> None:
    """Test bench for three-axis magnetometer calibration: simulate, calibrate, score against the truth."""


@cache
def program() -> Any:
    """Return the commands with their options; typer reads them from the functions in a twentieth of a second."""
    return typer.main.get_command(app)


def call(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns its exit status. Wrong use and bad input end as one line on standard error.

    Without arguments the help is shown.
    """
    arguments = (sys.argv[1:] if arguments is None else arguments) or ["--help"]
    if sys.stdout is None:  # closed by the shell: >&-
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115
    try:
        try:
            with in_options():
                status = program()(args=arguments, prog_name="magbench", standalone_mode=False)
        except SystemExit:  # of completion, done; and what typer and rich make of a closed pipe
            status = 0
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except Exception as error:
        return refuse(_in_words(error))
    return status if isinstance(status, int) else 0


def _in_words(error: Exception) -> str:
    """The message of an error with its remedy; a defect of the program is raised again."""
    from concurrent.futures.process import BrokenProcessPool

    match error:
        case typer.TyperException():
            return error.format_message().replace(WRAPPED, "")
        case InputError():
            return str(error)
        case UnicodeEncodeError(encoding="utf-8"):
            return f"{error.object!r} is not UTF-8 (rename the file, and use UTF-8 for names)"
        case BrokenProcessPool() | MemoryError():
            return "the system ended a process, perhaps for want of memory (try fewer --jobs, or a shorter run)"
        case OSError():
            what = f"{error.filename or 'system'}: {error.strerror or error}"
            return f"{what} (free space, or choose another place)"
    raise error
