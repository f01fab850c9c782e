"""`magbench inspect`: a first look at a recording, before calibrating or diagnosing."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from magbench.options import Data, Json, Maps, Run


def inspect(
    data: Data,
    map_: Maps = None,
    run: Run = 0,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Directory for report.html and inspect.json.")] = None,
    json: Json = False,
) -> None:
    """Tell what a recording holds, what it is fit for and what is odd: rates, units, motion, noise, faults.

    Example: magbench inspect log.csv --map time_s=t,unit=ms --map mag_x_nT=bx,unit=uT -o out/look
    """
    from magbench.console import emit, say, show_table
    from recordings.files import locked_directory
    from reports.text.inspection import finding_rows
    from validation.inspection.inspection import headline, inspect_file, summary

    with nullcontext() if out is None else locked_directory(out):
        inspection = inspect_file(data, maps=map_ or (), run=run)
        if out is not None:
            from reports.pages.inspection import write_inspection

            write_inspection(inspection, out)
    if json:
        emit(summary(inspection))
    else:
        show_table("", ["what", "", "value", "unit", "in words"], finding_rows(inspection), numbers=False)
    say(headline(inspection) + (f" {out}: report.html, inspect.json" if out is not None else ""))
