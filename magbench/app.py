"""The commands, one a file in `magbench.commands`, and what becomes of their errors."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from concurrent.futures.process import BrokenProcessPool

import typer

from magbench.cli import refuse
from magbench.commands import apply, calibrate, diagnose, inspect, listing, reproduce, run, schema, show, simulate
from scenarios.errors import InputError

EPILOG = (
    "Exit status: 0 done, 1 a gap was found and not explained, 2 wrong use or bad input (one line says what, where "
    "and what to do)."
)
app = typer.Typer(
    name="magbench",
    help="Test bench for three-axis magnetometer calibration: simulate, calibrate, score against the truth.",
    epilog=EPILOG,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
app.command("run")(run.run)
app.command("simulate")(simulate.simulate)
app.command("calibrate")(calibrate.calibrate)
app.command("apply")(apply.apply)
app.command("inspect")(inspect.inspect)
app.command("diagnose")(diagnose.diagnose)
app.command("reproduce")(reproduce.reproduce)
app.command("show")(show.show)
app.command("list")(listing.listing)
app.command("schema")(schema.schema)


def call(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns its exit status. Wrong use and bad input end as one line on standard error.

    Without arguments the help is shown.
    """
    arguments = (sys.argv[1:] if arguments is None else arguments) or ["--help"]
    if sys.stdout is None:  # closed by the shell: >&-
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115
    try:
        status = app(args=arguments, prog_name="magbench", standalone_mode=False)
        sys.stdout.flush()
    except (InputError, typer.TyperException) as error:
        return refuse(error.format_message() if isinstance(error, typer.TyperException) else str(error))
    except UnicodeEncodeError as error:
        if error.encoding != "utf-8":
            raise
        return refuse(f"{error.object!r} is not UTF-8 (rename the file, and use UTF-8 for names)")
    except (BrokenPipeError, SystemExit):  # a closed pipe; typer and rich turn it into an exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except (BrokenProcessPool, MemoryError):
        return refuse("the system ended a process, perhaps for want of memory (try fewer --jobs, or a shorter run)")
    except OSError as error:
        return refuse(f"{error.filename or 'system'}: {error.strerror or error} (free space, or choose another place)")
    return status if isinstance(status, int) else 0
