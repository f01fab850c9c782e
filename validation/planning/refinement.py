"""Refinement of legs: angles are varied one at a time, turns included in the error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from scenarios.paths.poses import nearest
from validation.planning.manoeuvre import YAW, Leg

if TYPE_CHECKING:
    from validation.planning.task import PlanningTask

STEPS_DEG = (40.0, 20.0, 10.0, 5.0)
"""Steps of an angle, in descending order."""
MOST_ROUNDS = 3
"""Rounds over all angles at most, for each step."""
GAIN = 5e-3
"""Relative reduction of the error by a round from which on the step is repeated."""


def refined(task: PlanningTask, legs: Sequence[Leg], time_s: float) -> tuple[tuple[Leg, ...], float]:
    """Return refined legs for a time and the error, by coordinate search; the remaining time is spent in holds.

    The error is that of the whole flight, with durations and information of the turns.
    """
    best = fitted(task, tuple(legs), time_s)
    error = np.inf if best is None else _error(task, best)
    here = tuple(legs) if best is None else best
    for step_deg in STEPS_DEG:
        for _ in range(MOST_ROUNDS):
            before = error
            here, error = _round(task, here, error, step_deg, time_s)
            if not error < (1.0 - GAIN) * before:
                break
    return here, error


def _round(
    task: PlanningTask, here: tuple[Leg, ...], error: float, step_deg: float, time_s: float
) -> tuple[tuple[Leg, ...], float]:
    """Try each angle of each leg a step up and down, and keep improvements."""
    for place in range(len(here)):
        for axis in range(3):
            for way in (-step_deg, step_deg):
                moved = _moved(task, here[place], axis, way)
                tried = fitted(task, (*here[:place], moved, *here[place + 1 :]), time_s)
                found = np.inf if tried is None else _error(task, tried)
                if tried is not None and found < error:
                    here, error = tried, found
    return here, error


def _moved(task: PlanningTask, leg: Leg, axis: int, by_deg: float) -> Leg:
    """Return a leg with an angle moved, within the tilts."""
    angles = np.array(leg.angles_deg)
    angles[axis] += by_deg
    pitch, roll = task.tilts.pitch_deg, task.tilts.roll_deg
    angles[YAW] = nearest(angles[YAW])
    angles[1:] = np.clip(angles[1:], (-pitch, -roll), (pitch, roll))
    return Leg.at(np.round(angles, 1), leg.amount)


def fitted(task: PlanningTask, legs: tuple[Leg, ...], time_s: float) -> tuple[Leg, ...] | None:
    """Return the legs with amounts scaled so that the flight takes a time; None if turns alone take longer."""
    manoeuvre = task.manoeuvre
    moving_s = manoeuvre.phase([replace(leg, amount=manoeuvre.least) for leg in legs]).duration_s
    if moving_s > time_s:
        return None
    if manoeuvre.whole:
        return legs if manoeuvre.phase(legs).duration_s <= time_s else None
    beyond = np.array([leg.amount - manoeuvre.least for leg in legs])
    total = float(beyond.sum())
    share = np.full(len(legs), (time_s - moving_s) / len(legs)) if total <= 0 else beyond * (time_s - moving_s) / total
    return tuple(replace(leg, amount=manoeuvre.least + float(more)) for leg, more in zip(legs, share, strict=True))


def _error(task: PlanningTask, legs: tuple[Leg, ...]) -> float:
    """Return the goal's error from the whole intended flight."""
    return task.error_with(task.phase_information(task.manoeuvre.phase(legs)))
