"""`magbench plan`: the manoeuvre that calibrates a vehicle best."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from magbench.arguments import field_vector, known_scenario, none_of
from magbench.options import CORES, FieldVector, Jobs, Json, Maps, Overrides

if TYPE_CHECKING:
    from validation.bound.goal import Goal
    from validation.bound.limit import Tilts
    from validation.planning.next_leg import LegSequence
    from validation.planning.plan import Plan
    from validation.planning.task import PlanningTask

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
    typer.Option(help="What a method is told of the field: its strength, with or without a gyro, or all of it."),
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
    time_s: Time = None,
    target: Target = None,
    after: After = None,
    like: Like = LIKE,
    knowledge: Knowledge = "norm",
    tilt_limits: TiltLimits = None,
    noise_std_nT: Noise = None,
    field_enu_nT: FieldVector = None,
    map_: Maps = None,
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
    enu = field_vector(field_enu_nT)
    if after is None:
        none_of({"--field-enu-nT": enu, "--map": map_}, "speaks of a log", "name it with --after, or leave it out")
    from magbench.console import progress
    from sim.scenario import load
    from validation.comparison.engine import ProcessEngine
    from validation.planning.next_leg import onward
    from validation.planning.plan import planned
    from validation.planning.task import PlanningTask

    goal, size, tilts = _asked(target, tilt_limits)
    with progress(f"planning for the {vehicle}"):
        task = PlanningTask.of(
            vehicle, load(like, set_ or ()), knowledge, tilts=tilts, goal=goal, noise_std_nT=noise_std_nT
        )
        most_s = time_s or task.usual_s
        if after is not None:
            return _tell(onward(_after(task, after, noise_std_nT, map_, enu), most_s, size), out, json)
        found = planned(task, most_s, size)
        _tell(found.checked(trials, ProcessEngine(jobs)) if trials else found, out, json)


def _asked(target: str | None, tilt_limits: str | None) -> tuple[Goal, float | None, Tilts | None]:
    """The figure that is to be good, its size where one is asked for, and the tilts."""
    from validation.bound.goal import OFFSET, parsed_target
    from validation.bound.limit import Tilts

    goal, size = parsed_target(target, TARGET) if target else (OFFSET, None)
    return goal, size, Tilts.parsed(tilt_limits, TILTS) if tilt_limits else None


def _after(
    task: PlanningTask, log: Path, noise_std_nT: float | None, maps: list[str] | None, enu: Sequence[float] | None
) -> PlanningTask:
    from validation.bound.files import recording_experiment

    return task.after(recording_experiment(log, noise_std_nT=noise_std_nT, maps=maps or (), enu=enu))


def _tell(found: Plan | LegSequence, place: Path | None, json: bool) -> None:
    from magbench.console import emit, say, show_table
    from reports.outputs.plan import write_plan
    from validation.planning import next_leg_summary as onward_words
    from validation.planning import summary as words
    from validation.planning.plan import Plan

    out = place or Path("out") / f"plan-{found.task.name}"
    told = write_plan(found, out)
    if isinstance(found, Plan):
        rows, headline = words.rows(found), words.headline(found)
    else:
        rows, headline = onward_words.rows(found), onward_words.headline(found)
    if json:
        emit(told | {"out": str(out)})
    else:
        show_table("", words.HEADS, rows)
    say(headline)
    say(f"{out}: " + ("" if found.scenario is None else f"{found.scenario.name}.toml, ") + "plan.json, report.html")
