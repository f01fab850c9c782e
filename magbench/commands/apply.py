"""`magbench apply`: correct another recording with a calibration."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from magbench.arguments import present
from magbench.options import Data, Json, Run
from magbench.reading_options import reads_logs

if TYPE_CHECKING:
    from recordings.reading import Reading


@reads_logs("data")
def command(
    calibration: Annotated[Path, typer.Argument(metavar="CALIBRATION", help="A calibration.json.", callback=present)],
    data: Data,
    out: Annotated[Path, typer.Option("--out", "-o", help="The corrected recording, .parquet or .csv.")],
    reading: Reading,
    with_: Annotated[str | None, typer.Option("--with", help="Which of several calibrations.")] = None,
    run: Run = 0,
    page: Annotated[bool, typer.Option(help="Also a page beside the recording, with the ending .html.")] = True,
    json: Json = False,
) -> None:
    """Correct a recording with an earlier calibration. The magnetometer's columns are replaced.

    Of tolles_lawson the column scalar_nT is replaced.

    Example: magbench apply out/calibration.json survey.csv --with ellipsoid -o corrected.parquet
    """
    from magbench.api.apply import apply_file
    from magbench.console import emit, progress, say, show_text, warn

    with progress(f"correcting {data.name}"):
        done = apply_file(calibration, data, out, name=with_, run=run, reading=reading, page=page)
    warn(done["warning"])
    if json:
        emit(done | {"out": str(out)})
    else:
        show_text(done["answer"])
    written = f"{out} and {done['page']}" if page else str(out)
    say(f"{written}: {done['samples']} samples of {done['corrected']} corrected with {done['calibrator']}")
