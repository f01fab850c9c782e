"""The functions for what is possible: the bound, the manoeuvre to fly, and which model is worth its parameters."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from magbench.inputs import in_keywords, recording_from, reference_from, scenario_from
from scenarios.errors import InputError

if TYPE_CHECKING:
    from typing import Literal

    from calib.reference import Reference
    from magbench.api import Data
    from magbench.bounds_results import BoundResult, OnwardResult, PlanResult
    from sim.scenario import Scenario
    from validation.bound.goal import Goal
    from validation.bound.limit import Tilts
    from validation.cross_validation.workflow import Worth

    Knowledge = Literal["norm", "norm+gyro", "norm+gyro+accel", "vector", "vector+eddy"]


@in_keywords()
def bound(
    source: Scenario | Data,
    knowledge: Knowledge = "norm",
    *,
    field_strength_nT: float | None = None,
    field_enu_nT: Sequence[float] | None = None,
    noise_std_nT: float | None = None,
    gyro_noise_rad_s: float | None = None,
    gyro_scale_std: float = 0.0,
    strength_unknown: bool = False,
    coloured: bool = False,
    tilt_limits: tuple[float, float] | None = None,
    overrides: Sequence[str] = (),
    maps: Sequence[str] = (),
    run: int = 0,
) -> BoundResult:
    """The least errors that any method can reach with a scenario or a recording, and what is not observable.

    source : a scenario by name, TOML file or `magbench.load`; else data as in `calibrate`, with its reference.
    knowledge : what a method is told of the field. noise_std_nT, gyro_noise_rad_s : white noise; default: as found.
    gyro_scale_std : what the gyro's scale may be off by, a fraction.
    coloured, overrides : of a scenario, its flicker noise and random walk too; values changed. tilt_limits : roll and
    pitch, degrees, within which the best of any motion is asked.
    """
    from magbench.bounds_results import BoundResult
    from validation.bound.files import experiment_of
    from validation.bound.knowledge import KNOWLEDGE
    from validation.bound.query import BoundQuery

    if knowledge not in KNOWLEDGE:
        raise InputError(
            f"{knowledge!r} is nothing that is known", where="knowledge", do=f"one of {', '.join(KNOWLEDGE)}"
        )
    tilts = _tilts(tilt_limits)
    question = BoundQuery(
        knowledge, not strength_unknown, noise_std_nT, gyro_noise_rad_s, tilts, coloured, gyro_scale_std
    )
    scenario = _scenario(source, overrides)
    if scenario is not None:
        return BoundResult.of(question.of_scenario(scenario))
    if coloured or overrides:
        raise InputError(
            "speaks of a scenario, and this is a recording", where="coloured, overrides", do="leave it out"
        )
    recording = recording_from(source, maps=maps, run=run)
    reference = reference_from(source, run, field_strength_nT, field_enu_nT)
    return BoundResult.of(question.answer(experiment_of(recording, reference, noise_std_nT)))


@in_keywords()
def plan(
    vehicle: str,
    time_s: float | None = None,
    *,
    target: str | None = None,
    after: Data | None = None,
    like: str | Path | Scenario = "standard-full",
    knowledge: Literal["norm", "norm+gyro", "vector"] = "norm",
    tilt_limits: tuple[float, float] | None = None,
    noise_std_nT: float | None = None,
    field_enu_nT: Sequence[float] | None = None,
    trials: int = 0,
    overrides: Sequence[str] = (),
    maps: Sequence[str] = (),
) -> PlanResult | OnwardResult:
    """The manoeuvre that calibrates a vehicle best in a time; with `after` the legs that go on from a recording.

    vehicle : a name of `magbench list vehicles`, or "hand". target : "offset_rms_nT=2" and the like: the shortest that
    is so good. like : field, sensor and errors. trials : flights that confirm it. `scenario` of what comes back is
    what `magbench.run` flies.
    """
    from magbench.bounds_results import OnwardResult, PlanResult
    from validation.bound.files import experiment_of
    from validation.comparison.engine import ProcessEngine
    from validation.planning.next_leg import onward
    from validation.planning.plan import planned
    from validation.planning.task import PlanningTask

    goal, size = _goal(target)
    spec, tilts = scenario_from(like, overrides), _tilts(tilt_limits)
    task = PlanningTask.of(vehicle, spec, knowledge, tilts=tilts, goal=goal, noise_std_nT=noise_std_nT)
    most_s = time_s or task.usual_s
    if after is not None:
        known = experiment_of(recording_from(after, maps=maps), _reference(after, field_enu_nT), noise_std_nT)
        return OnwardResult.of(onward(task.after(known), most_s, size))
    found = planned(task, most_s, size)
    return PlanResult.of(found.checked(trials, ProcessEngine(1)) if trials else found)


@in_keywords()
def worth(
    data: Data,
    field_strength_nT: float | None = None,
    *,
    field_enu_nT: Sequence[float] | None = None,
    maps: Sequence[str] = (),
    run: int = 0,
) -> tuple[Worth, ...]:
    """Whether soft iron, eddy currents and a temperature predict unseen legs better; of each sensor.

    Data and reference as in `calibrate`.
    """
    from validation.cross_validation.workflow import worth as found

    return found(recording_from(data, maps=maps, run=run), reference_from(data, run, field_strength_nT, field_enu_nT))


def _scenario(source: object, overrides: Sequence[str]) -> Scenario | None:
    """What `source` names or is; None for data."""
    from scenarios.names import find
    from sim.scenario import Scenario

    if isinstance(source, Scenario):
        return scenario_from(source, overrides)
    if (
        isinstance(source, str | PathLike)
        and find(Path(source) if isinstance(source, PathLike) else source).suffix == ".toml"
    ):
        return scenario_from(source, overrides)
    return None


def _goal(target: str | None) -> tuple[Goal, float | None]:
    """The figure that is to be good, and its size where one is asked for."""
    from validation.bound.goal import OFFSET, parsed_target

    return parsed_target(target, "target") if target else (OFFSET, None)


def _reference(data: Data, field_enu_nT: Sequence[float] | None) -> Reference:
    return reference_from(data, 0, None, field_enu_nT)


def _tilts(limits: tuple[float, float] | None) -> Tilts | None:
    from validation.bound.limit import Tilts

    return None if limits is None else Tilts.checked(*limits, "tilt_limits")
