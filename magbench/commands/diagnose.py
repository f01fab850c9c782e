"""`magbench diagnose`: where a measured recording and a model disagree, and what is missing."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from magbench.arguments import all_present, complete_scenario, field_vector, known_scenario, present
from magbench.options import FieldStrength, FieldVector, Json
from magbench.reading_options import reads_logs

if TYPE_CHECKING:
    from collections.abc import Sequence

    from magbench.api.recheck_result import RecheckResult
    from magbench.api.results import DiagnosisResult, PooledDiagnosisResult
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
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Output directory.  [default: out/diagnosis]")] = None,
    json: Json = False,
) -> None:
    """Find where a recording and a model disagree, name the missing effect, show that the gap shrinks.

    Several recordings are diagnosed together: effects with common coefficients, effects whose coefficients differ, and
    effects of a single recording. The sensors of an array are diagnosed each, and compared; --sensor 2 selects a
    sensor, --reference-sensor 2 takes its reading for the field.
    Exit status 1 where a gap was found and not explained.

    Example: magbench diagnose monday.parquet tuesday.parquet friday.parquet --model auv-dive -o out/diagnosis
    """
    from magbench.api.diagnose import diagnose
    from magbench.console import say

    iron = _iron(model, measured, reading, (field_strength_nT, field_vector(field_enu_nT)), (run or 0, sensor))
    place = out or Path("out") / "diagnosis"
    found = diagnose(
        measured,
        model,
        field_strength_nT=field_strength_nT,
        field_enu_nT=field_vector(field_enu_nT),
        confirm=confirm,
        actuators=actuator or (),
        reading=reading,
        run=run,
        sensor=sensor,
        reference_sensor=reference_sensor,
        out=place,
        say=lambda stage: say(f"diagnosis: {stage}"),
    )
    _show(found, iron, place, json)
    if not found.verdict.explained or any(one.verdict == "changed" for one in iron):
        raise typer.Exit(1)


def _show(
    found: DiagnosisResult | PooledDiagnosisResult, iron: Sequence[RecheckResult], place: Path, json: bool
) -> None:
    """The stated calibrations' iron, and the diagnosis."""
    from magbench.api.stated_calibration import changed_iron
    from magbench.console import emit, say, show_text
    from magbench.tables import show_answer
    from reports.outputs.diagnosis import FILES

    stated = [changed_iron(one) for one in iron]
    if json:
        told = {"stated_calibration": stated} if stated else {}
        emit(found.as_dict() | {"model_out": str(place / "model.toml")} | told)
    else:
        for one in stated:
            show_text(f"the stated calibration: {one['sentence']}\n")
        show_answer(found.presented)
    say(f"{place}: {', '.join(FILES)}")


def _iron(
    model: str | None,
    measured: list[Path],
    reading: Reading,
    field: tuple[float | None, tuple[float, float, float] | None],
    which: tuple[int, int | None],
) -> list[RecheckResult]:
    """A calibration in place of the model, against each recording; none for a model."""
    from magbench.api.recheck import recheck
    from magbench.api.stated_calibration import is_calibration

    if model is None or not is_calibration(model):
        return []

    strength_nT, vector_nT = field
    options = {"field_enu_nT": vector_nT, "reading": reading, "run": which[0], "sensor": which[1]}
    return [recheck(model, one, strength_nT, **options) for one in measured]  # type: ignore[arg-type]
