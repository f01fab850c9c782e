"""`magbench plan`: the manoeuvre that calibrates a vehicle best."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from magbench.arguments import field_vector, known_scenario, none_of
from magbench.options import CORES, FieldVector, Jobs, Json, Overrides
from magbench.reading_options import reads_logs

if TYPE_CHECKING:
    from recordings.reading import Reading

LIKE = "standard-full"
"""Field, sensor and noise that are planned for, where nobody says others: the standard case's."""
TARGET, TILTS = "--target", "--tilt-limits"
VehicleName = Annotated[str, typer.Argument(metavar="VEHICLE", help="A name of `magbench list vehicles`, or hand.")]
Time = Annotated[
    float | None,
    typer.Option(
        "--time", metavar="S", min=1.0, max=86_400.0, help="The most it may take.  [default: 600, by hand 120]"
    ),
]
After = Annotated[
    Path | None,
    typer.Option(
        metavar="DATA", help="Go on from a recording: the next legs, what each gains, until that no longer pays."
    ),
]
Target = Annotated[
    str | None,
    typer.Option(
        TARGET,
        metavar="FIGURE=SIZE",
        help="The shortest that is so good: offset_rms_nT=2, heading_rms_deg=0.01.",
    ),
]
Like = Annotated[
    str,
    typer.Option(metavar="SCENARIO", help="Field, sensor, errors and sampling planned for.", callback=known_scenario),
]
Knowledge = Annotated[
    Literal["norm", "norm+gyro", "vector"],
    typer.Option(help="Knowledge of the method: the field strength, with or without a gyro, or the field vector."),
]
TiltLimits = Annotated[
    str | None,
    typer.Option(TILTS, metavar="ROLL,PITCH", help="Tilts to stay within, degrees.  [default: the vehicle's]"),
]
Noise = Annotated[
    float | None,
    typer.Option("--noise-std-nT", min=1e-9, help="White noise of each axis.  [default: the scenario's]"),
]
Trials = Annotated[int, typer.Option(min=0, max=100_000, help="Flights that confirm it; 0: none.")]
PlanOut = Annotated[Path | None, typer.Option("--out", "-o", help="Output directory.  [default: out/plan-VEHICLE]")]


@reads_logs("after")
def command(
    vehicle: VehicleName,
    reading: Reading,
    time_s: Time = None,
    target: Target = None,
    after: After = None,
    like: Like = LIKE,
    knowledge: Knowledge = "norm",
    tilt_limits: TiltLimits = None,
    noise_std_nT: Noise = None,
    field_enu_nT: FieldVector = None,
    trials: Trials = 100,
    jobs: Jobs = CORES,
    set_: Overrides = None,
    out: PlanOut = None,
    json: Json = False,
) -> None:
    """Plan the manoeuvre that calibrates a vehicle best in a time. Or the shortest that is good enough; fly it.

    The manoeuvre is written as a scenario for `run`, and compared with the limit of all motions within its tilts.

    Example: magbench plan auv --time 600 --target offset_rms_nT=8 -o out/plan
    """
    enu = field_vector(field_enu_nT)
    if after is None:
        none_of(reading.stated, "speaks of a log", "name it with --after, or leave it out")
    from magbench.api.plan import plan
    from magbench.console import emit, progress, say, show_table, show_text
    from validation.planning.summary import HEADS

    place = out or Path("out") / f"plan-{vehicle}"
    with progress(f"planning for the {vehicle}"):
        found = plan(
            vehicle,
            time_s,
            target=target,
            after=after,
            like=like,
            knowledge=knowledge,
            tilt_limits=tilt_limits,
            noise_std_nT=noise_std_nT,
            field_enu_nT=enu,
            trials=trials,
            jobs=jobs,
            overrides=set_ or (),
            reading=reading,
            out=place,
        )
    if json:
        emit((found.written or {}) | {"out": str(place)})
    else:
        show_text(f"{found!r}\n")
        show_table("", HEADS, found.rows())
    scenario = "" if found.scenario is None else f"{found.scenario.name}.toml, "
    say(f"{place}: {scenario}plan.json, report.html")
