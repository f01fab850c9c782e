"""`magbench plan`: the manoeuvre that calibrates a vehicle best."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from magbench.arguments import known_scenario
from magbench.options import CORES, Jobs, Json, Overrides

if TYPE_CHECKING:
    from validation.planning.plan import Plan

LIKE = "standard-full"
"""Field, sensor and noise that are planned for, where nobody says others: the standard case's."""
TARGET, TILTS = "--target", "--tilt-limits"
VehicleName = Annotated[str, typer.Argument(metavar="VEHICLE", help="A name of `magbench list vehicles`.")]
Time = Annotated[float, typer.Option("--time", metavar="S", min=1.0, max=86_400.0, help="The most it may take.")]
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
    Literal["norm", "vector"], typer.Option(help="What a method is told of the field: its strength, or all of it.")
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


def plan(
    vehicle: VehicleName,
    time_s: Time = 600.0,
    target: Target = None,
    like: Like = LIKE,
    knowledge: Knowledge = "norm",
    tilt_limits: TiltLimits = None,
    noise_std_nT: Noise = None,
    trials: Trials = 100,
    jobs: Jobs = CORES,
    set_: Overrides = None,
    out: PlanOut = None,
    json: Json = False,
) -> None:
    """Plan the manoeuvre that calibrates a vehicle best in a time, or the shortest that is good enough; fly it.

    It is written as a scenario that `run` flies, and set beside the limit that its tilts allow any motion.

    Example: magbench plan auv --time 600 --target offset_rms_nT=8 -o out/plan
    """
    from magbench.console import progress
    from sim.scenario import load
    from validation.bound.goal import OFFSET, parsed_target
    from validation.bound.limit import Tilts
    from validation.comparison.engine import Processes
    from validation.planning.plan import planned
    from validation.planning.task import Task

    goal, size = parsed_target(target, TARGET) if target else (OFFSET, None)
    tilts = Tilts.parsed(tilt_limits, TILTS) if tilt_limits else None
    with progress(f"planning for the {vehicle}"):
        task = Task.of(vehicle, load(like, set_ or ()), knowledge, tilts=tilts, goal=goal, noise_std_nT=noise_std_nT)
        found = planned(task, time_s, size)
        found = found.checked(trials, Processes(jobs)) if trials else found
    _tell(found, out or Path("out") / found.scenario.name, json)


def _tell(found: Plan, out: Path, json: bool) -> None:
    from magbench.console import emit, say, show_table
    from validation.outputs.plan import FILES, write_plan
    from validation.planning.words import HEADS, headline, rows, summary

    file = write_plan(found, out)
    if json:
        emit(summary(found, str(file)) | {"out": str(out)})
    else:
        show_table("", HEADS, rows(found))
    say(headline(found))
    say(f"{out}: {FILES.format(found.scenario.name)}")
