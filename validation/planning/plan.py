"""Plan of a manoeuvre: the simulated flight, the error by the bound, and the ratio to the limit of the tilts."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from scenarios.errors import InputError
from sim.scenario import Scenario
from sim.simulation import plan, true_motion
from validation.bound.limit import Limit, limit, tilts_deg
from validation.bound.query import BoundAnswer, BoundQuery
from validation.bound.station_keeping import staying_limit
from validation.comparison.engine import Engine
from validation.planning import linked
from validation.planning.search import NEAR, LegSelection, RouteSearch, selections
from validation.planning.task import PlanningTask
from validation.planning.verification import Confirmed, confirmed

MOST_TRIES = 4
"""Flights at most to meet a target that the first plan, made without physics, misses by a little."""
MARGIN = 1.005
"""Factor on the time from the ratio of squares, so that the next flight meets the target."""
USUAL = 99.0
"""Percentile of the flown tilts that is reported, since pushes overshoot for tenths of a second."""


@dataclass(frozen=True, eq=False)
class Plan:
    """Plan with the simulated flight.

    error : goal's error by the bound of the flown motion; least : limit of the tilts for as many samples
    staying : limit for a vehicle that remains in place and tilts only by thrust; None if the vehicle can hold a tilt
    flown_deg : |roll| and |pitch| that are not exceeded 99 % of the time
    """

    choice: LegSelection
    target: float | None
    scenario: Scenario
    answer: BoundAnswer
    error: float
    least: Limit
    staying: Limit | None
    flown_deg: tuple[float, float]
    confirmed: Confirmed | None = None

    @property
    def task(self) -> PlanningTask:
        """Return the task of the plan."""
        return self.choice.task

    @property
    def time_s(self) -> float:
        """Return the duration of the manoeuvre in s."""
        return self.choice.phase.duration_s

    @property
    def ratio(self) -> float:
        """Return the ratio of error to limit."""
        return self.error / self.least.value

    @property
    def staying_ratio(self) -> float | None:
        """Return the ratio of error to the limit of a vehicle that remains in place."""
        return None if self.staying is None else self.error / self.staying.value

    @property
    def met(self) -> bool:
        """Return whether the target, if any, is met."""
        return self.target is None or self.error <= self.target

    def checked(self, trials: int, engine: Engine) -> Plan:
        """Return the plan verified by trials of the flown motion."""
        return replace(self, confirmed=confirmed(self.scenario, self.task.goal, trials, engine))


def planned(task: PlanningTask, time_s: float, target: float | None = None) -> Plan:
    """Return the shortest manoeuvre that meets the target within a time, or the best if none does or without target.

    Raises InputError if no manoeuvre within the time determines the goal.
    """
    if task.linked:
        choice = linked.linked(task, time_s) if target is None else linked.shortest(task, target, time_s)
        if not np.isfinite(choice.error):
            raise _undetermined()
        return _flown(choice, target)
    if target is None:
        return _best(task, time_s)
    search = RouteSearch(task, time_s)
    choice = search.shortest(target, time_s)
    search.improve(choice.time_s)
    choice = search.shortest(target, choice.time_s if choice.error <= target else time_s)
    if not np.isfinite(choice.error):
        raise _undetermined()
    found = _flown(choice, target)
    for _ in range(MOST_TRIES):
        if found.met or found.choice.time_s >= time_s:
            break
        longer_s = longer_time_s(found.choice.time_s, found.error / target)
        found = _flown(search.best(min(longer_s, time_s)), target)
    return found


def longer_time_s(time_s: float, ratio: float) -> float:
    """Return the time in which the error falls by a ratio, with the root of the time, and a MARGIN more."""
    return MARGIN * time_s * max(1.0, ratio**2)


def _best(task: PlanningTask, time_s: float) -> Plan:
    """Return the best manoeuvre for a time; further variants are tried if the first is too far from the limit."""
    best: Plan | None = None
    for choice, _ in selections(task, time_s):
        if np.isfinite(choice.error):
            found = _flown(choice, None)
            best = found if best is None or found.error < best.error else best
        if best is not None and best.ratio <= NEAR:
            break
    if best is None:
        raise _undetermined()
    return best


def _undetermined() -> InputError:
    do = "give more --time, wider --tilt-limits, or more knowledge with --knowledge vector"
    return InputError("no manoeuvre in this time determines the goal", where="--time", do=do)


def _flown(choice: LegSelection, target: float | None) -> Plan:
    task, phase = choice.task, choice.phase
    legs = f"{len(choice.legs)} attitudes" if len(choice.legs) > 1 else "an attitude"
    summary = f"Planned for {task.goal.name} from {task.knowledge}: {legs} in {phase.duration_s:.0f} s"
    scenario = task.scenario([phase], summary)
    answer = BoundQuery(task.knowledge, noise_std_nT=task.known.noise_std_nT).of_scenario(scenario)
    error = task.error(answer.bound.information.matrix)
    least = limit(answer.known, task.knowledge, task.tilts, task.goal)
    staying = staying_limit(answer.known, task.knowledge, task.tilts, task.goal) if task.manoeuvre.stays else None
    return Plan(choice, target, scenario, answer, error, least, staying, _tilts(scenario))


def _tilts(scenario: Scenario) -> tuple[float, float]:
    q = np.concatenate([motion.kinematics.q for motion in true_motion(plan(scenario))])
    pitch, roll = np.percentile(tilts_deg(Rotation.from_quat(q, scalar_first=True)), USUAL, axis=0)
    return float(roll), float(pitch)
