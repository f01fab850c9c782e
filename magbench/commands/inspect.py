"""`magbench inspect`: a first look at a recording, before calibrating or diagnosing."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from magbench.options import Data, FieldStrength, Json, Run
from magbench.reading_options import reads_logs

if TYPE_CHECKING:
    from recordings.reading import Reading


@reads_logs("data")
def command(
    data: Data,
    reading: Reading,
    run: Run = 0,
    field_strength_nT: FieldStrength = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Directory for report.html and inspect.json.")] = None,
    json: Json = False,
) -> None:
    """Report rates, units, motion, noise and faults of a recording, and the calibrations it suffices for.

    Example: magbench inspect log.csv --map time_s=t,unit=ms --map mag_x_nT=bx,unit=uT -o out/look
    """
    from magbench.api.inspect import inspect
    from magbench.console import emit, say, show_table
    from reports.text.inspection import finding_rows
    from validation.inspection.inspection import headline, summary

    found = inspect(data, field_strength_nT, reading=reading, run=run, out=out)
    if json:
        emit(summary(found))
    else:
        show_table("", ["what", "", "value", "unit", "in words"], finding_rows(found), numbers=False)
    say(headline(found) + (f" {out}: report.html, inspect.json" if out is not None else ""))
