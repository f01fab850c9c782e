"""`magbench.plan`."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from magbench.api.inputs import (
    Data,
    engine,
    in_keywords,
    reading_from,
    recording_and_reference,
    scenario_from,
    tilts_from,
)

if TYPE_CHECKING:
    from magbench.api.planning_results import OnwardResult, PlanResult
    from recordings.reading import Reading
    from sim.scenario import Scenario
    from validation.bound.limit import Tilts
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
    reading: Reading | None = None,
    out: str | PathLike[str] | None = None,
) -> PlanResult | OnwardResult:
    """The manoeuvre that calibrates a vehicle best in a time; with `after` the legs that go on from a recording.

    vehicle : a name of `magbench list vehicles`, or "hand". target : "offset_rms_nT=2" and the like: the shortest that
        reaches it. like : field, sensor and errors. trials : confirming flights, on `jobs` processes.
    field_enu_nT : the field planned for, in place of `like`'s; with `after` the field of a log that does not say.
    out : directory for the scenario, plan.json and report.html; by default none is written.

    The result's `scenario` is what `magbench.run` flies. Raises InputError for an unknown vehicle or figure.

    >>> import magbench
    >>> found = magbench.plan("hand", 60)
    >>> print(repr(found).split(" determine")[0])
    4 attitudes in 60 s
    >>> found.scenario.phases[0].kind
    'poses'
    """
    from magbench.api.planning_results import plan_result
    from reports.outputs.plan import write_plan

    scenario = _in_field(scenario_from(like, overrides), field_enu_nT if after is None else None)
    task, size = _task(vehicle, scenario, knowledge, tilts_from(tilt_limits), target, noise_std_nT)
    most_s = time_s or task.usual_s
    if after is None:
        found = _from_start(task, most_s, size, trials, jobs)
    else:
        found = _after(task, after, reading_from(after, maps, reading), (noise_std_nT, field_enu_nT), most_s, size)
    return plan_result(found, write_plan(found, Path(out)) if out else None)


def _in_field(like: Scenario, field_enu_nT: Sequence[float] | None) -> Scenario:
    """The scenario, in a stated field; InputError for an impossible one."""
    from validation.calibrating.reference import stated_reference
    from validation.planning.task import in_field

    if field_enu_nT is None:
        return like
    stated = stated_reference(like.name, None, field_enu_nT)
    return in_field(like, stated.field_enu_nT or field_enu_nT)


def _task(
    vehicle: str,
    like: Scenario,
    knowledge: str,
    tilts: Tilts | None,
    target: str | None,
    noise_std_nT: float | None,
) -> tuple[PlanningTask, float | None]:
    """What is planned, and the size of the figure to be reached."""
    from validation.bound.goal import OFFSET, parsed_target
    from validation.planning.task import PlanningTask

    goal, size = parsed_target(target, "--target") if target else (OFFSET, None)
    return PlanningTask.of(vehicle, like, knowledge, tilts=tilts, goal=goal, noise_std_nT=noise_std_nT), size


def _from_start(
    task: PlanningTask, most_s: float, size: float | None, trials: int, jobs: int | None
) -> Plan | LegSequence:
    from validation.planning.plan import planned

    found = planned(task, most_s, size)
    return found.checked(trials, engine(None, jobs)) if trials else found


def _after(
    task: PlanningTask,
    after: Data,
    reading: Reading,
    stated: tuple[float | None, Sequence[float] | None],
    most_s: float,
    size: float | None,
) -> Plan | LegSequence:
    """The next legs; stated : the noise and the field vector."""
    from validation.bound.files import experiment_of
    from validation.planning.next_leg import next_legs

    noise_std_nT, field_enu_nT = stated
    recording, reference = recording_and_reference(after, (None, field_enu_nT), reading=reading)
    where = str(after) if isinstance(after, str | PathLike) else "recording"
    known = experiment_of(recording.in_nT(where), reference, noise_std_nT, where)
    return next_legs(task.after(known), most_s, size)
