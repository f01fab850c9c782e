"""`magbench calibrate`: fit calibrators to a simulated or measured recording."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from magbench.arguments import chosen, field_vector
from magbench.options import Data, Exec, FieldStrength, FieldVector, Json, Maps, Run, TimeLimit, With
from validation.calibrating.children import TIME_LIMIT_S

USUAL = ("sphere", "ellipsoid")
"""Who calibrates where nobody is named."""


def calibrate(
    data: Data,
    with_: With = None,
    exec_: Exec = None,
    time_limit_s: TimeLimit = TIME_LIMIT_S,
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
    """Calibrate a recording and print offset and matrix; by sphere and ellipsoid, unless --with or --exec say by whom.

    Status 1 where one who is named was not applicable.

    Example: magbench calibrate log.csv --map mag_x_nT=bx,unit=uT --with ellipsoid --field-strength-nT 48152
    """
    from calib import to_dict
    from magbench.console import emit, end_with
    from magbench.tables import show_calibrations
    from sim.dataset.files import locked_directory
    from validation.calibrating.files import write_calibrations
    from validation.calibrating.fitting import calibrate_file, not_applicable

    forms = _forms(export, out)
    calibrators = chosen(with_, exec_, time_limit_s, USUAL)
    with nullcontext() if out is None else locked_directory(out):
        results = calibrate_file(
            data, calibrators, run=run, maps=map_ or (), strength_nT=field_strength_nT, enu=field_vector(field_enu_nT)
        )
        if out is not None:
            write_calibrations(results, out, forms)
    if json:
        emit({"calibrations": {name: to_dict(result) for name, result in results.items()}})
    else:
        show_calibrations(results)
    end_with(not_applicable(results) if with_ or exec_ else [])


def _forms(export: str | None, out: Path | None) -> Sequence[str]:
    """The forms that are asked for; InputError for others, and where there is no directory for them."""
    from scenarios.errors import InputError
    from validation.calibrating.export import known_forms

    forms = known_forms(export) if export else ()
    if forms and out is None:
        raise InputError("exports need a directory", where="--export", do="add -o DIRECTORY")
    return forms
