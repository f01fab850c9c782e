"""`magbench apply`: correct another recording with a calibration."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from magbench.options import Json


def apply(
    calibration: Annotated[Path, typer.Argument(metavar="CALIBRATION", help="A calibration.json.")],
    data: Annotated[Path, typer.Argument(metavar="DATA", help="A dataset directory, a run, or a Parquet or CSV log.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="The corrected recording, .parquet or .csv.")],
    with_: Annotated[str | None, typer.Option("--with", help="Which of several calibrations.")] = None,
    run: Annotated[int, typer.Option(min=0, help="Which run of a dataset directory.")] = 0,
    map_: Annotated[
        list[str] | None, typer.Option("--map", help="Rename and convert a column, e.g. --map mag_x_nT=bx,unit=uT")
    ] = None,
    json: Json = False,
) -> None:
    """Correct a recording with a calibration made before; the magnetometer's columns are replaced.

    Example: magbench apply out/calibration.json survey.csv --with ellipsoid -o corrected.parquet
    """
    from magbench.console import emit, say, warn
    from validation.calibrating.files import apply_file

    told = apply_file(calibration, data, out, name=with_, run=run, maps=map_ or ())
    warn(told["warning"])
    say(f"{out}: {told['samples']} samples corrected with {told['calibrator']}")
    if json:
        emit(told | {"out": str(out)})
