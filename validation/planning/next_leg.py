"""Next legs after a recording, with the gain of each, until a further leg no longer pays."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from scenarios.errors import InputError
from scenarios.paths.poses import nearest
from sim.scenario import Scenario
from validation.bound.bound import Bound
from validation.bound.files import scenario_experiment
from validation.bound.limit import Limit, limit
from validation.planning import linked
from validation.planning.search import NEAR, LegSelection, design_error, selections
from validation.planning.task import PlanningTask

LEGS_S = (60.0, 120.0, 240.0)
"""Tried lengths of a leg; the leg with the fastest gain is flown. Short legs may not reach the missing attitudes."""
PAYS = 0.1
"""Least relative reduction of the error a minute for a leg to pay; doubling a recording gives 30 %."""
MINUTE_S = 60.0


@dataclass(frozen=True, eq=False)
class NextLeg:
    """Next leg, with the goal's error before and after."""

    choice: LegSelection
    before: float
    after: float

    @property
    def gain(self) -> float:
        """Return the reduction of the error, infinite if the goal was unobservable before."""
        return self.before - self.after

    @property
    def rate(self) -> float:
        """Return the rate of ln(error) reduction a minute."""
        return _rate(self.before, self.after, self.choice.phase.duration_s)

    def beats(self, after: float, time_s: float) -> bool:
        """Return whether the leg gains faster than one of another time and error; by error where both first do."""
        return bool((self.rate, -self.after) >= (_rate(self.before, after, time_s), -after))

    @property
    def pays(self) -> bool:
        """Return whether the leg reduces the error fast enough."""
        return bool(self.rate >= -np.log1p(-PAYS))


@dataclass(frozen=True, eq=False)
class LegSequence:
    """Legs that pay, the first leg that does not (`idle`), and the limit of the tilts for the total time.

    error : goal's error from the recording and the simulated legs; None if no leg pays
    """

    task: PlanningTask
    legs: tuple[NextLeg, ...]
    idle: NextLeg | None
    scenario: Scenario | None
    error: float | None
    least: Limit | None


def next_legs(task: PlanningTask, time_s: float, target: float | None = None) -> LegSequence:
    """Return the next legs after a recording (`PlanningTask.after`), each the best given all before, within a time.

    The sequence ends when a further leg no longer pays, or the target is met.
    Raises InputError if no manoeuvre within the time determines the goal.
    """
    assert task.before is not None
    information, yaw_deg, left_s = task.before, task.manoeuvre.yaw_deg, time_s
    legs: list[NextLeg] = []
    idle = None
    while not (target is not None and legs and legs[-1].after <= target):
        found = _leg(task.going_on(information, yaw_deg), left_s)
        if found is None:
            break
        if not found.pays:
            idle = found
            break
        legs.append(found)
        information = information + found.choice.information
        yaw_deg = nearest(found.choice.legs[-1].yaw_deg)
        left_s -= found.choice.phase.duration_s
    if not legs and idle is None:
        do = "give more --time, wider --tilt-limits, or more knowledge with --knowledge vector"
        raise InputError("no leg in this time determines the goal", where="--time", do=do)
    return _flown(task, tuple(legs), idle)


def _leg(task: PlanningTask, left_s: float) -> NextLeg | None:
    """Return the leg with the fastest gain; None if no leg in the remaining time determines the goal."""
    assert task.before is not None
    before = task.error(task.before)
    best: NextLeg | None = None
    for leg_s in sorted(LEGS_S, reverse=True):
        if leg_s > left_s or (best is not None and best.beats(design_error(task, leg_s), leg_s)):
            continue
        choice = _best(task, leg_s)
        if np.isfinite(choice.error) and (best is None or not best.beats(choice.error, choice.phase.duration_s)):
            best = NextLeg(choice, before, choice.error)
    return best


def _rate(before: float, after: float, time_s: float) -> float:
    return float(np.log(before / after)) * MINUTE_S / time_s


def _best(task: PlanningTask, leg_s: float) -> LegSelection:
    """Return the best selection for a time; variants as for a plan, until one is near the optimal design."""
    if task.linked:
        return linked.linked(task, leg_s)
    tried: list[LegSelection] = []
    for choice, least in selections(task, leg_s):
        tried.append(choice)
        if choice.error <= NEAR * least:
            break
    return min(tried, key=lambda one: one.error)


def _flown(task: PlanningTask, legs: tuple[NextLeg, ...], idle: NextLeg | None) -> LegSequence:
    assert task.before is not None
    if not legs:
        return LegSequence(task, legs, idle, None, None, None)
    phases = [leg.choice.phase for leg in legs]
    scenario = task.scenario(phases, f"{len(legs)} legs after a recording, for {task.goal.name}")
    flown = replace(scenario_experiment(scenario, task.known.noise_std_nT), matrix=task.known.matrix)
    information = task.before + Bound.of(flown, task.knowledge).information.matrix
    least = limit(flown, task.knowledge, task.tilts, task.goal, task.before)
    return LegSequence(task, legs, idle, scenario, task.error(information), least)
