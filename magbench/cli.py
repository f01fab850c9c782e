"""The command line: one command a file in `magbench.commands`."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from concurrent.futures.process import BrokenProcessPool

import typer

from magbench.commands import apply, calibrate, inspect, listing, reproduce, run, schema, show, simulate
from scenarios.errors import InputError

EPILOG = "Exit status: 0 done, 2 wrong use or bad input (one line says what, where and what to do)."
INTERRUPTED = 130
app = typer.Typer(
    name="magbench",
    help="Test bench for three-axis magnetometer calibration: simulate, calibrate, score against the truth.",
    epilog=EPILOG,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
app.command("run")(run.run)
app.command("simulate")(simulate.simulate)
app.command("calibrate")(calibrate.calibrate)
app.command("inspect")(inspect.inspect)
app.command("apply")(apply.apply)
app.command("reproduce")(reproduce.reproduce)
app.command("show")(show.show)
app.command("list")(listing.listing)
app.command("schema")(schema.schema)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns its exit status. Wrong use and bad input end as one line on standard error."""
    if sys.stdout is None:  # closed by the shell: >&-
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115
    try:
        status = app(args=arguments, prog_name="magbench", standalone_mode=False)
        sys.stdout.flush()
    except (InputError, typer.TyperException) as error:
        return _refuse(error.format_message() if isinstance(error, typer.TyperException) else str(error))
    except (typer.Abort, KeyboardInterrupt):
        status = INTERRUPTED
    except (BrokenPipeError, SystemExit):  # a closed pipe; typer and rich turn it into an exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except (BrokenProcessPool, MemoryError):
        return _refuse("the system ended a process, perhaps for want of memory (try fewer --jobs, or a shorter run)")
    except OSError as error:
        return _refuse(f"{error.filename or 'system'}: {error.strerror or error} (free space, or choose another place)")
    if status == INTERRUPTED:  # typer turns Ctrl-C into this status
        return _refuse("interrupted; the same command resumes", INTERRUPTED)
    return status if isinstance(status, int) else 0


def _refuse(message: str, status: int = 2) -> int:
    print("magbench: " + " ".join(message.split()), file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main())
