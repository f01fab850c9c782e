"""`magbench calibrate`: fit calibrators to a simulated or measured recording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from magbench.options import Json


def calibrate(
    data: Annotated[Path, typer.Argument(metavar="DATA", help="A dataset directory, a run, or a Parquet or CSV log.")],
    with_: Annotated[str, typer.Option("--with", help="Calibrators, comma-separated.")] = "sphere,ellipsoid",
    run: Annotated[int, typer.Option(min=0, help="Which run of a dataset directory.")] = 0,
    field_strength_nT: Annotated[
        float | None, typer.Option("--field-strength-nT", help="Field strength; a simulated run knows its own.")
    ] = None,
    field_enu_nT: Annotated[
        str | None, typer.Option("--field-enu-nT", metavar="E,N,U", help="Field vector, east, north, up.")
    ] = None,
    map_: Annotated[
        list[str] | None, typer.Option("--map", help="Rename and convert a column, e.g. --map mag_x_nT=bx,unit=uT")
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Directory for calibration.json and exports.")] = None,
    export: Annotated[
        str | None, typer.Option(help="Also write offset and matrix as c, px4, ardupilot, ros (comma-separated).")
    ] = None,
    json: Json = False,
) -> None:
    """Calibrate a recording and print offset and matrix.

    Example: magbench calibrate log.csv --map mag_x_nT=bx,unit=uT --with ellipsoid --field-strength-nT 48152
    """
    from calib import to_dict
    from magbench.console import emit
    from magbench.tables import show_calibrations
    from scenarios.errors import InputError
    from validation.calibrating.files import write_calibrations
    from validation.calibrating.fitting import calibrate_file

    if export and out is None:
        raise InputError("exports need a directory", where="--export", do="add -o DIRECTORY")
    names = [name.strip() for name in with_.split(",") if name.strip()]
    results = calibrate_file(data, names, run=run, maps=map_ or (), strength_nT=field_strength_nT, enu=field_enu_nT)
    if out is not None:
        write_calibrations(results, out, export.split(",") if export else ())
    if json:
        emit({"calibrations": {name: to_dict(result) for name, result in results.items()}})
    else:
        show_calibrations(results)
