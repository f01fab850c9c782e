"""`magbench calibrate`: fit calibrators to a simulated or measured recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from magbench.arguments import chosen, field_vector
from magbench.options import Data, Exec, FieldStrength, FieldVector, Json, Maps, Run, TimeLimit, With
from validation.calibrating.processes import TIME_LIMIT_S

if TYPE_CHECKING:
    from calib.result import Calibration
    from validation.cross_validation.claimed_std import Claim
    from validation.cross_validation.workflow import Worth

USUAL = ("sphere", "ellipsoid")
"""Who calibrates where nobody is named."""

CalibrationOut = Annotated[Path | None, typer.Option("--out", "-o", help="Directory for calibration.json and exports.")]
Export = Annotated[
    str | None, typer.Option(help="Also write offset and matrix as c, px4, ardupilot, ros (comma-separated).")
]
AskWorth = Annotated[
    bool,
    typer.Option("--worth", help="Also tell whether soft iron, eddy currents, temperature predict unseen legs better."),
]


def calibrate(
    data: Data,
    with_: With = None,
    exec_: Exec = None,
    time_limit_s: TimeLimit = TIME_LIMIT_S,
    run: Run = 0,
    field_strength_nT: FieldStrength = None,
    field_enu_nT: FieldVector = None,
    map_: Maps = None,
    out: CalibrationOut = None,
    export: Export = None,
    worth: AskWorth = False,
    json: Json = False,
) -> None:
    """Calibrate a recording and print offset and matrix; by sphere and ellipsoid, unless --with or --exec say by whom.

    Status 1 where one who is named was not applicable.

    Example: magbench calibrate log.csv --map mag_x_nT=bx,unit=uT --with ellipsoid --field-strength-nT 48152
    """
    from magbench.console import end_with
    from recordings.files import locked_directory
    from validation.calibrating.calibration_file import write_calibrations
    from validation.calibrating.fitting import fit_all, not_applicable
    from validation.calibrating.reference import recording_and_reference
    from validation.cross_validation.claimed_std import claims_of
    from validation.cross_validation.workflow import worth as worth_of

    forms = _forms(export, out)
    calibrators = chosen(with_, exec_, time_limit_s, USUAL)
    with nullcontext() if out is None else locked_directory(out):
        recording, reference = recording_and_reference(
            data, run=run, maps=map_ or (), strength_nT=field_strength_nT, enu=field_vector(field_enu_nT)
        )
        results = fit_all(recording, reference, calibrators)
        if out is not None:
            write_calibrations(results, out, forms)
    _tell(results, claims_of(results, recording, reference), worth_of(recording, reference) if worth else None, json)
    end_with(not_applicable(results) if with_ or exec_ else [])


def _tell(
    results: Mapping[str, Calibration], claims: Mapping[str, Claim], found: Sequence[Worth] | None, json: bool
) -> None:
    """The calibrations, which claims cannot be believed as they are, and what is worth its parameters where asked."""
    from calib import to_dict
    from magbench.console import emit, show_text
    from magbench.tables import show_calibrations
    from validation.cross_validation.summary import claim_lines, claim_summary, headline, summary

    if json:
        told = {} if found is None else {"worth": [summary(one) for one in found]}
        calibrations = {name: to_dict(result) for name, result in results.items()}
        emit({"calibrations": calibrations, "claims": claim_summary(claims), **told})
        return
    show_calibrations(results)
    for line in (*claim_lines(claims), *(headline(one) for one in found or ())):
        show_text(line)


def _forms(export: str | None, out: Path | None) -> Sequence[str]:
    """The forms that are asked for; InputError for others, and where there is no directory for them."""
    from scenarios.errors import InputError
    from validation.calibrating.export import known_forms

    forms = known_forms(export) if export else ()
    if forms and out is None:
        raise InputError("exports need a directory", where="--export", do="add -o DIRECTORY")
    return forms
