"""`magbench.plan`."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from magbench.api.inputs import Data, engine, in_keywords, recording_from, reference_from, scenario_from, tilts_from

if TYPE_CHECKING:
    from magbench.api.planning_results import OnwardResult, PlanResult
    from sim.scenario import Scenario
    from validation.planning.next_leg import LegSequence
    from validation.planning.plan import Plan
    from validation.planning.task import PlanningTask


@in_keywords()
def plan(
    vehicle: str,
    time_s: float | None = None,
    *,
    target: str | None = None,
    after: Data | None = None,
    like: str | Path | Scenario = "standard-full",
    knowledge: Literal["norm", "norm+gyro", "vector"] = "norm",
    tilt_limits: tuple[float, float] | str | None = None,
    noise_std_nT: float | None = None,
    field_enu_nT: Sequence[float] | None = None,
    trials: int = 0,
    jobs: int | None = None,
    overrides: Sequence[str] = (),
    maps: Sequence[str] = (),
    out: str | PathLike[str] | None = None,
) -> PlanResult | OnwardResult:
    """The manoeuvre that calibrates a vehicle best in a time; with `after` the legs that go on from a recording.

    vehicle : a name of `magbench list vehicles`, or "hand". target : "offset_rms_nT=2" and the like: the shortest that
        reaches it. like : field, sensor and errors. trials : confirming flights, on `jobs` processes.
    out : directory for the scenario, plan.json and report.html; by default none is written.

    The result's `scenario` is what `magbench.run` flies. Raises InputError for an unknown vehicle or figure.
    """
    from magbench.api.planning_results import plan_result
    from reports.outputs.plan import write_plan
    from validation.bound.goal import OFFSET, parsed_target
    from validation.planning.task import PlanningTask

    goal, size = parsed_target(target, "--target") if target else (OFFSET, None)
    spec, tilts = scenario_from(like, overrides), tilts_from(tilt_limits)
    task = PlanningTask.of(vehicle, spec, knowledge, tilts=tilts, goal=goal, noise_std_nT=noise_std_nT)
    most_s = time_s or task.usual_s
    if after is None:
        found = _from_start(task, most_s, size, trials, jobs)
    else:
        found = _after(task, after, most_s, size, maps, noise_std_nT, field_enu_nT)
    return plan_result(found, write_plan(found, Path(out)) if out else None)


def _from_start(
    task: PlanningTask, most_s: float, size: float | None, trials: int, jobs: int | None
) -> Plan | LegSequence:
    from validation.planning.plan import planned

    found = planned(task, most_s, size)
    return found.checked(trials, engine(None, jobs)) if trials else found


def _after(
    task: PlanningTask,
    after: Data,
    most_s: float,
    size: float | None,
    maps: Sequence[str],
    noise_std_nT: float | None,
    field_enu_nT: Sequence[float] | None,
) -> Plan | LegSequence:
    from validation.bound.files import experiment_of
    from validation.planning.next_leg import next_legs

    reference = reference_from(after, 0, None, field_enu_nT)
    where = str(after) if isinstance(after, str | PathLike) else "recording"
    known = experiment_of(recording_from(after, maps=maps), reference, noise_std_nT, where)
    return next_legs(task.after(known), most_s, size)
