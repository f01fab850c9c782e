"""`magbench recheck`: whether an old calibration still holds for the instrument that wrote a log."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from magbench.arguments import field_vector
from magbench.options import Data, FieldStrength, FieldVector, Json, Run
from magbench.reading_options import reads_logs

if TYPE_CHECKING:
    from recordings.reading import Reading

Old = Annotated[
    str,
    typer.Argument(
        metavar="OLD",
        help="A calibration.json; parameters of PX4, ArduPilot, Betaflight, INAV; a result of MotionCal, Magneto, "
        "imu_calib; or `applied`: in force in the log.",
    ),
]
Tolerance = Annotated[
    float | None,
    typer.Option("--tolerance-deg", help="Heading error from which on a change matters.  [default: 1]"),
]
Compass = Annotated[
    str | None, typer.Option(help="Which calibration of OLD: a name, or the compass's number in its parameters.")
]
OldUnit = Annotated[
    str | None,
    typer.Option("--old-unit", metavar="UNIT", help="Unit of an OLD that tells none: uT, mG, ..., counts=NT_A_COUNT."),
]
OldNorm = Annotated[
    float | None,
    typer.Option("--old-norm", help="Length of the field as OLD's matrix gives it, such as 1 for a unit sphere."),
]
Sensor = Annotated[int | None, typer.Option(min=1, help="Which sensor of an array, from 1.")]


@reads_logs("data")
def command(
    old: Old,
    data: Data,
    reading: Reading,
    tolerance_deg: Tolerance = None,
    compass: Compass = None,
    old_unit: OldUnit = None,
    old_norm: OldNorm = None,
    sensor: Sensor = None,
    run: Run = 0,
    field_strength_nT: FieldStrength = None,
    field_enu_nT: FieldVector = None,
    json: Json = False,
) -> None:
    """Tell whether a calibration still holds for a log. The answer is valid, changed or cannot tell.

    Changes of offset, scale, soft iron and motor currents are told with 95 % intervals and the heading error on a level
    survey. Exit status 1 where the calibration was not found valid.

    Example: magbench recheck calibration.json today.csv --field-strength-nT 48152 --tolerance-deg 2
    """
    from magbench.api.recheck import recheck
    from magbench.console import emit, progress, show_table, show_text
    from validation.rechecking.summary import HEADS, headline, rows

    with progress(f"comparing with {data.name}"):
        found = recheck(
            old,
            data,
            field_strength_nT,
            field_enu_nT=field_vector(field_enu_nT),
            tolerance_deg=tolerance_deg,
            compass=compass,
            old_unit=old_unit,
            old_norm=old_norm,
            sensor=sensor,
            reading=reading,
            run=run,
        )
    if json:
        emit(found.summary())
    else:
        show_text(headline(found) + "\n")
        lines = [[cell.replace(", ", "\n") for cell in row] for row in rows(found)]  # a line a component
        show_table(f"{found.old.name} against the log", HEADS, lines, numbers=False)
        for note in found.notes:
            show_text(note)
    if found.verdict != "valid":
        raise typer.Exit(1)
