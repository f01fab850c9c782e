"""`magbench diagnose`: where a measured recording and a model disagree, and what is missing."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from magbench.arguments import all_present, complete_scenario, field_vector, known_scenario, present
from magbench.options import FieldStrength, FieldVector, Json, Scheduler
from magbench.reading_options import reads_logs

if TYPE_CHECKING:
    from magbench.api.diagnosis_results import DiagnosisResult, PooledDiagnosisResult
    from recordings.reading import Reading

Model = Annotated[
    str | None,
    typer.Option(
        help="A scenario or model file, or a calibration as of `recheck`: its iron is compared with the fitted.  "
        "[default: hard iron, soft iron, white noise, fitted]",
        callback=known_scenario,
        autocompletion=complete_scenario,
    ),
]
Confirm = Annotated[
    Path | None, typer.Option(help="A second recording: the finding must hold there too.", callback=present)
]
Actuators = Annotated[
    list[str] | None,
    typer.Option("--actuator", metavar="COLUMN", help="Treat a channel like a motor current; may be repeated."),
]


Measured = Annotated[
    list[Path],
    typer.Argument(
        metavar="DATA...",
        help="Recordings: dataset directories with all their runs, runs, or Parquet or CSV logs; several are diagnosed "
        "together.",
        callback=all_present,
    ),
]
Sensor = Annotated[
    int | None,
    typer.Option(min=1, help="Which sensor of an array, from 1.  [default: every one, and how they differ]"),
]
ReferenceSensor = Annotated[
    int | None,
    typer.Option(min=1, help="The sensor of an array whose reading is the field, in place of attitude and field."),
]
Numbers = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="NUMBER=VALUE", help="Another number of the policy that decides, e.g. alpha=0.001; repeatable."
    ),
]
OneRun = Annotated[int | None, typer.Option(min=0, help="Which run of a dataset directory.  [default: all]")]


@reads_logs("measured")
def command(
    measured: Measured,
    reading: Reading,
    model: Model = None,
    confirm: Confirm = None,
    field_enu_nT: FieldVector = None,
    field_strength_nT: FieldStrength = None,
    actuator: Actuators = None,
    run: OneRun = None,
    sensor: Sensor = None,
    reference_sensor: ReferenceSensor = None,
    set_: Numbers = None,
    scheduler: Scheduler = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Output directory.  [default: out/diagnosis]")] = None,
    json: Json = False,
) -> None:
    """Name the effects that the model of a recording misses.

    Shown are where both disagree, and how much less with the effects in the model.

    Several recordings are diagnosed together: effects with common coefficients, effects whose coefficients differ, and
    effects of a single recording. The sensors of an array are diagnosed each, and compared; --sensor 2 selects a
    sensor, --reference-sensor 2 takes its reading for the field.
    Exit status 1 where a gap was found and not explained, and where a stated calibration's iron has changed.

    Example: magbench diagnose monday.parquet tuesday.parquet friday.parquet --model auv-dive -o out/diagnosis
    """
    from diagnosis.policy import STANDARD, changed
    from magbench.api.diagnose import diagnose
    from magbench.console import progress, say

    place = out or Path("out") / "diagnosis"
    with progress("diagnosis"):
        found = diagnose(
            measured,
            model,
            field_strength_nT=field_strength_nT,
            field_enu_nT=field_vector(field_enu_nT),
            confirm=confirm,
            policy=changed(STANDARD, set_ or ()),
            actuators=actuator or (),
            reading=reading,
            run=run,
            sensor=sensor,
            reference_sensor=reference_sensor,
            scheduler=scheduler,
            out=place,
            say=lambda stage: say(f"diagnosis: {stage}"),
        )
    _show(found, place, json)
    if not found.verdict.explained or any(one.answer.verdict == "changed" for one in found.stated):
        raise typer.Exit(1)


def _show(found: DiagnosisResult | PooledDiagnosisResult, place: Path, json: bool) -> None:
    """The answer, the stated calibration's before the diagnosis."""
    from magbench.console import emit, say
    from magbench.diagnosis_tables import show_answer
    from reports.outputs.diagnosis import FILES

    if json:
        emit(found.presented.summary | {"model_out": str(place / "model.toml")})
    else:
        show_answer(found.presented)
    say(f"{place}: {', '.join(FILES)}")
