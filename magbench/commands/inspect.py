"""`magbench inspect`: a first look at a recording, before calibrating or diagnosing."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from magbench.options import Data, FieldStrength, Json, Run
from magbench.reading_options import reads_logs

if TYPE_CHECKING:
    from magbench.api.inspection_result import InspectionResult
    from recordings.reading import Reading


@reads_logs("data", notes=False)
def command(
    data: Data,
    reading: Reading,
    run: Run = 0,
    field_strength_nT: FieldStrength = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Directory for report.html and inspect.json.")] = None,
    full: Annotated[bool, typer.Option("--full", help="Print every finding, those in order too.")] = False,
    json: Json = False,
) -> None:
    """Tell what a recording suffices for, and what is wrong in it.

    Looked at are rates, units, frames, motion, noise and faults.

    Example: magbench inspect log.csv --map time_s=t,unit=ms --map mag_x_nT=bx,unit=uT -o out/look
    """
    from magbench.api.inspect import inspect
    from magbench.console import emit, progress, say
    from validation.inspection.inspection import summary

    with progress(f"inspecting {data.name}"):
        found = inspect(data, field_strength_nT, reading=reading, run=run, out=out)
    if json:
        emit(summary(found))
    else:
        _show(found, full=full)
    if out is not None:
        say(f"{out}: report.html, inspect.json")


def _show(found: InspectionResult, *, full: bool) -> None:
    """The answer, then what needs attention, or every finding."""
    from magbench.console import show_points, show_table, show_text
    from reports.text.inspection import answer_texts, attention_points, finding_rows
    from validation.text import counted

    show_text("\n".join(answer_texts(found)) + "\n")
    if full:
        show_table("", ["what", "", "value", "unit", "in words"], finding_rows(found), numbers=False)
        return
    show_points(attention_points(found))
    in_order = sum(one.level == "ok" for one in found.findings)
    show_text(f"\n{counted(in_order, 'finding')} in order: --full lists them; -o OUT draws the recording.")
