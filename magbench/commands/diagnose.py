"""`magbench diagnose`: where a measured recording and a model disagree, and what is missing."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from magbench.arguments import complete_scenario, field_vector, known_scenario, present
from magbench.options import Data, FieldStrength, FieldVector, Json, Maps, Run

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
    list[str] | None, typer.Option("--actuator", metavar="COLUMN", help="Treat a channel like a motor current.")
]


def diagnose(
    measured: Data,
    model: Model = None,
    confirm: Confirm = None,
    field_enu_nT: FieldVector = None,
    field_strength_nT: FieldStrength = None,
    map_: Maps = None,
    actuator: Actuators = None,
    run: Run = 0,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Output directory.  [default: out/diagnosis]")] = None,
    json: Json = False,
) -> None:
    """Find where a recording and a model disagree, name the missing effect, show that the gap shrinks.

    Exit status 1 where a gap was found and not explained.

    Example: magbench diagnose log.parquet --model auv-dive --confirm second.parquet -o out/diagnosis
    """
    from magbench.console import emit, say
    from magbench.tables import show_diagnosis
    from sim.dataset.files import locked_directory, remove_leftovers
    from validation.diagnosis.files import diagnose_file
    from validation.outputs.diagnosis import FILES, write_diagnosis

    place = out or Path("out") / "diagnosis"
    with locked_directory(place):
        remove_leftovers(place)
        found = diagnose_file(
            measured,
            model,
            confirm=confirm,
            enu=field_vector(field_enu_nT),
            strength_nT=field_strength_nT,
            maps=map_ or (),
            actuators=actuator or (),
            run=run,
            say=lambda what: say(f"diagnosis: {what}"),
        )
        say("diagnosis: report and recording")
        write_diagnosis(found, place, f"Diagnosis of {measured.name}")
    if json:
        emit(found.as_dict() | {"model_out": str(place / "model.toml")})
    else:
        show_diagnosis(found)
    say(f"{place}: {', '.join(FILES)}")
    if not found.verdict.explained:
        raise typer.Exit(1)
