"""`magbench calibrate`: fit calibrators to a simulated or measured recording."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from magbench.arguments import complete_calibrators, field_vector, known_calibrators, split
from magbench.options import Data, FieldStrength, FieldVector, Json, Maps, Run


def calibrate(
    data: Data,
    with_: Annotated[
        str,
        typer.Option(
            "--with",
            help="Calibrators, comma-separated.",
            callback=known_calibrators,
            autocompletion=complete_calibrators,
        ),
    ] = "sphere,ellipsoid",
    run: Run = 0,
    field_strength_nT: FieldStrength = None,
    field_enu_nT: FieldVector = None,
    map_: Maps = None,
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
    from sim.dataset.files import locked_directory
    from validation.calibrating.export import known_forms
    from validation.calibrating.files import write_calibrations
    from validation.calibrating.fitting import calibrate_file

    forms = known_forms(export) if export else ()
    if forms and out is None:
        raise InputError("exports need a directory", where="--export", do="add -o DIRECTORY")
    with nullcontext() if out is None else locked_directory(out):
        results = calibrate_file(
            data, split(with_), run=run, maps=map_ or (), strength_nT=field_strength_nT, enu=field_vector(field_enu_nT)
        )
        if out is not None:
            write_calibrations(results, out, forms)
    if json:
        emit({"calibrations": {name: to_dict(result) for name, result in results.items()}})
    else:
        show_calibrations(results)
