"""`magbench calibrate`: fit calibrators to a simulated or measured recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from magbench.arguments import field_vector, split
from magbench.options import Data, Exec, FieldStrength, FieldVector, Json, Run, TimeLimit, With
from magbench.reading_options import reads_logs
from validation.calibrating.processes import TIME_LIMIT_S

if TYPE_CHECKING:
    from magbench.api.calibration_results import Calibrations
    from recordings.reading import Reading
    from validation.assessment.assessment import Assessment
    from validation.cross_validation.claimed_std import Claim
    from validation.cross_validation.workflow import CrossValidation

CalibrationOut = Annotated[Path | None, typer.Option("--out", "-o", help="Directory for calibration.json and exports.")]
Export = Annotated[
    str | None, typer.Option(help="Also write offset and matrix as c, px4, ardupilot, ros (comma-separated).")
]
Force = Annotated[
    bool, typer.Option("--force", help="Export estimates that are not ok too, with the status in a comment.")
]
UnitOut = Annotated[
    str | None,
    typer.Option(
        "--unit-out",
        metavar="UNIT",
        help="Offset and matrix also in uT, mG, ..., counts=NT_A_COUNT, or `log`: as --unit or --map states.",
    ),
]
AskOthers = Annotated[
    bool,
    typer.Option("--others", help="Also the figures of ArduPilot, MAGFit, Betaflight, MotionCal, NXP on this log."),
]
Tolerance = Annotated[
    float | None,
    typer.Option(
        "--tolerance-deg",
        metavar="T",
        help="Also answer whether the heading error on a level survey is below T: yes, no or undecidable at 95 %.",
    ),
]
Base = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="A base station's record (IAGA-2002): the day's change is taken off first."),
]
BaseStart = Annotated[
    str | None,
    typer.Option(metavar="TIME", help="UTC at the log's time 0, where it tells none: 2024-05-01T12:30."),
]
AskWorth = Annotated[
    bool,
    typer.Option("--worth", help="Also test whether soft iron, eddy currents, temperature predict unseen legs better."),
]


@reads_logs("data")
def command(
    data: Data,
    reading: Reading,
    with_: With = None,
    exec_: Exec = None,
    time_limit_s: TimeLimit = TIME_LIMIT_S,
    run: Run = 0,
    field_strength_nT: FieldStrength = None,
    field_enu_nT: FieldVector = None,
    out: CalibrationOut = None,
    export: Export = None,
    force: Force = False,
    unit_out: UnitOut = None,
    base: Base = None,
    base_start: BaseStart = None,
    worth: AskWorth = False,
    tolerance_deg: Tolerance = None,
    others: AskOthers = False,
    json: Json = False,
) -> None:
    """Calibrate a recording, and tell how good the result is. By default by sphere and ellipsoid.

    A level turn is calibrated by planar too, a log with x and y alone by planar, and one with varying motor currents,
    throttle or temperature by motor_ellipsoid too.

    Status 1 where a calibrator of --with or --exec was not applicable, 2 where an export is refused; table and other
    files are there all the same.

    Example: magbench calibrate log.csv --map mag_x_nT=bx,unit=uT --with ellipsoid --field-strength-nT 48152
    """
    from magbench.api.calibrate import calibrate
    from magbench.console import end_with, progress
    from validation.calibrating.calibration_file import RefusedExportsError
    from validation.calibrating.fitting import not_applicable

    refused = None
    try:
        with progress(f"calibrating {data.name}"):
            found = calibrate(
                data,
                field_strength_nT,
                with_=split(with_) if with_ else [],
                field_enu_nT=field_vector(field_enu_nT),
                reading=reading,
                run=run,
                exec_=exec_ or (),
                time_limit_s=time_limit_s,
                out=out,
                exports=export.split(",") if export else (),
                force=force,
                unit_out=unit_out,
                base=base,
                base_start=base_start,
                tolerance_deg=tolerance_deg,
            )
    except RefusedExportsError as error:
        found, refused = error.calibrations, error
    _show(found, _gains(found) if worth else None, found.assessment, json, others=others)
    _tell_files(out, export, refused)
    end_with(not_applicable(found) if with_ or exec_ else [], refused)


def _tell_files(out: Path | None, exports: str | None, refused: Exception | None) -> None:
    """What was written, and the command that uses it; nothing beside a refusal, which is one line."""
    from magbench.console import say

    if out and refused is None:
        more = f", exports for {exports}" if exports else ""
        say(f"{out}: report.html, calibration.json{more}; `magbench apply {out}/calibration.json LOG` corrects a log")


def _gains(found: Calibrations) -> Sequence[CrossValidation]:
    from magbench.api.cross_validate import worth

    return worth(found.recording, found.reference.strength_nT, field_enu_nT=found.reference.field_enu_nT)


def _show(
    found: Calibrations, gains: Sequence[CrossValidation] | None, assessment: Assessment, json: bool, *, others: bool
) -> None:
    """The verdict, the calibrations, faults of the sensor, contradicted claims, and where asked what is worth it."""
    from magbench.calibration_tables import show_calibrations, show_in_unit
    from magbench.console import emit, show_text
    from validation.assessment.wording import lines
    from validation.cross_validation.summary import claim_lines, headline
    from validation.screening.screening import screening_lines

    claims = found.claims()
    if json:
        known = {"known_figures": _known_summary(found)} if others else {}
        emit(_summary(found, gains, assessment, claims) | known)
        return
    show_text("\n".join(lines(assessment)) + "\n")
    show_calibrations(found)
    if found.unit:
        show_in_unit(found, found.unit)
    if found.change:
        show_text(found.change.line)
    for line in (*screening_lines(found.screening), *claim_lines(claims), *(headline(one) for one in gains or ())):
        show_text(line)
    if others:
        _show_known(found)


def _known_summary(found: Calibrations) -> dict[str, object]:
    return {name: [one.summary() for one in known] for name, known in found.known_figures().items()}


def _show_known(found: Calibrations) -> None:
    """The figures of other programs, a table a calibration."""
    from magbench.console import show_table
    from validation.known_figures.figures import HEADS

    for name, known in found.known_figures().items():
        if known:
            show_table(f"{name}: figures of other programs", HEADS, [one.row() for one in known], numbers=False)


def _summary(
    found: Calibrations,
    gains: Sequence[CrossValidation] | None,
    assessment: Assessment,
    claims: Mapping[str, Claim],
) -> dict[str, Any]:
    """The JSON of `--json`."""
    from calib import to_dict
    from validation.assessment import wording
    from validation.calibrating.output_unit import in_unit
    from validation.cross_validation.summary import claim_summary, summary

    told = {name: wording.calibration_summary(one) for name, one in assessment.calibrations.items()}
    plain: dict[str, Any] = {"calibrations": {name: to_dict(result) | told[name] for name, result in found.items()}}
    plain |= {"screening": found.screening.summary(), "claims": claim_summary(claims)} | wording.summary(assessment)
    plain |= {} if gains is None else {"worth": [summary(one) for one in gains]}
    plain |= {"in_unit": in_unit(found, found.unit)} if found.unit else {}
    return plain | ({"base": found.change.summary()} if found.change else {})
