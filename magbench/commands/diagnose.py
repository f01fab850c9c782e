"""`magbench diagnose`: where a measured recording and a model disagree, and what is missing."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from magbench.arguments import all_present, complete_scenario, field_vector, known_scenario, present
from magbench.options import FieldStrength, FieldVector, Json, Maps

if TYPE_CHECKING:
    from diagnosis.several.files import Source
    from diagnosis.verdict import Verdict

Model = Annotated[
    str | None,
    typer.Option(
        help="A scenario or model file.  [default: hard iron, soft iron, white noise, fitted]",
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
        help="Recordings: dataset directories with all their runs, runs, or Parquet or CSV logs. Of several it is told "
        "what holds in all of them with one coefficient, and what does not.",
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


def diagnose(
    measured: Measured,
    model: Model = None,
    confirm: Confirm = None,
    field_enu_nT: FieldVector = None,
    field_strength_nT: FieldStrength = None,
    map_: Maps = None,
    actuator: Actuators = None,
    run: OneRun = None,
    sensor: Sensor = None,
    reference_sensor: ReferenceSensor = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Output directory.  [default: out/diagnosis]")] = None,
    json: Json = False,
) -> None:
    """Find where a recording and a model disagree, name the missing effect, show that the gap shrinks.

    Of several recordings: what holds in all of them, what does not transfer, what one alone shows. Of an array: every
    sensor, and what differs between them, or one, as by --sensor 2; --reference-sensor 2 compares with that one.
    Exit status 1 where a gap was found and not explained.

    Example: magbench diagnose monday.parquet tuesday.parquet friday.parquet --model auv-dive -o out/diagnosis
    """
    from diagnosis.several.files import check_one, sources
    from magbench.console import say
    from recordings.files import locked_directory, remove_leftovers
    from reports.outputs.diagnosis import FILES

    place, recordings = out or Path("out") / "diagnosis", sources(measured, run, sensor, map_ or (), reference_sensor)
    if confirm:
        check_one(recordings, "--confirm")
    given = {
        "enu": field_vector(field_enu_nT),
        "strength_nT": field_strength_nT,
        "maps": map_ or (),
        "actuators": actuator or (),
        "say": lambda what: say(f"diagnosis: {what}"),
    }
    with locked_directory(place):
        remove_leftovers(place)
        if len(recordings) > 1:
            verdict = _several(recordings, model, place, given, json=json)
        else:
            verdict = _one(measured[0], recordings[0], model, confirm, place, given, json=json)
    say(f"{place}: {', '.join(FILES)}")
    if not verdict.explained:
        raise typer.Exit(1)


def _one(
    measured: Path,
    one: Source,
    model: str | None,
    confirm: Path | None,
    place: Path,
    given: dict[str, Any],
    *,
    json: bool,
) -> Verdict:
    from diagnosis.single import diagnose_file
    from magbench.console import emit
    from magbench.tables import show_diagnosis
    from reports.outputs.diagnosis import write_diagnosis

    which: dict[str, Any] = {"run": one.run, "sensor": one.sensor, "reference_sensor": one.reference}
    found = diagnose_file(measured, model, confirm=confirm, **which, **given)
    given["say"]("report and recording")
    write_diagnosis(found, place, f"Diagnosis of {measured.name}")
    if json:
        emit(found.as_dict() | {"model_out": str(place / "model.toml")})
    else:
        show_diagnosis(found)
    return found.verdict


def _several(
    recordings: tuple[Source, ...], model: str | None, place: Path, given: dict[str, Any], *, json: bool
) -> Verdict:
    from diagnosis.several.files import diagnose_files
    from magbench.console import emit
    from magbench.tables import show_together
    from reports.outputs.diagnosis import write_pooled_diagnosis

    found = diagnose_files(recordings, model, **given)
    given["say"]("reports and recordings")
    folders = write_pooled_diagnosis(found, place, f"Diagnosis of {len(recordings)} {found.among.key}")
    if json:
        emit(found.as_dict() | {"model_out": str(place / "model.toml")})
    else:
        show_together(found)
    given["say"](f"each by itself: {', '.join(folders)}")
    return found.verdict
