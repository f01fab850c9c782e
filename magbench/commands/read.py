"""`magbench read`: a log of any format as a recording."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from magbench.arguments import present
from magbench.options import Json
from magbench.reading_options import reads_logs

if TYPE_CHECKING:
    from magbench.api.log_result import LogResult
    from recordings.reading import Reading

MOST_ROWS = 40
"""Columns that are listed on the terminal; --json lists all."""
LOG_HELP = "A log: .bin, .ulg, .bag, .csv, ..., or the directory of a log."
Log = Annotated[Path, typer.Argument(metavar="LOG", help=LOG_HELP, callback=present)]


@reads_logs("log")
def command(
    log: Log,
    reading: Reading,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="The recording, .parquet or .csv.")] = None,
    json: Json = False,
) -> None:
    """Read a log and show what was found.

    Magnetometers, rates, frame, place, calibration in force, columns.
    The other commands read logs themselves; -o keeps the recording for other programs.

    Example: magbench read flight.bin -o flight.parquet
    """
    from magbench.api.read import read
    from magbench.console import emit, progress, say

    with progress(f"reading {log.name}"):
        found = read(log, out=out, reading=reading)
    if json:
        emit(found.summary() | {"out": None if out is None else str(out)})
    else:
        _show(found)
    if out is not None:
        say(f"{out}: {len(found.recording)} samples written")


def _show(found: LogResult) -> None:
    """The log in words, then a table of its columns."""
    from magbench.console import show_table, show_text
    from reports.text.log import log_lines
    from validation.text import figure

    for line in log_lines(found.form, found.recording, found.rate_hz, found.field_enu_nT):
        show_text(line)
    table = found.to_frame()
    texts = table[["lowest", "median", "highest"]].map(lambda value: figure(value, 4))
    rows = [[*row] for row in zip(table["column"], table["unit"], *(texts[name] for name in texts), strict=True)]
    show_table("columns", ["column", "unit", "lowest", "median", "highest"], rows[:MOST_ROWS])
    if len(rows) > MOST_ROWS:
        show_text(f"and {len(rows) - MOST_ROWS} more channels; --json lists them all")
