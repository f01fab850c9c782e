"""Manoeuvres for a method with a gyro, which links what the samples tell: legs shown again and again."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from scenarios.arrays import Array
from validation.bound.information import SYMMETRIC
from validation.bound.knowledge import PLACES
from validation.planning.refinement import fitted
from validation.planning.search import LegSelection, RouteSearch
from validation.planning.task import PlanningTask

GUIDES = ("vector", "norm")
"""What the legs are chosen for: a good gyro tells what a known attitude does, a poor one leaves the strength."""
TIMES = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32)
"""How often the legs are shown: a gyro's noise adds up, and so it tells more of turns that follow each other soon."""
MOST_LEGS = 1000
"""Of a phase."""
LEAST_S = 100.0
"""No target is met in less: the gyro's bias has to be found too."""
CLOSE = 1.03
"""To which the shortest time is found."""


def linked(task: PlanningTask, time_s: float) -> LegSelection:
    """The best for a time, by the bound along the attitudes as they are meant; its error infinite where none tells."""
    return min(_tried(task, time_s), key=lambda one: one.error)


def shortest(task: PlanningTask, target: float, most_s: float) -> LegSelection:
    """The shortest that is as good as the target, found by halving; the best in most_s where none is."""
    best, low, high = linked(task, most_s), min(LEAST_S, most_s), most_s
    while best.error <= target and high > CLOSE * low:
        middle = float(np.sqrt(low * high))
        tried = linked(task, middle)
        if tried.error <= target:
            best, high = tried, middle
        else:
            low = middle
    return best


def _tried(task: PlanningTask, time_s: float) -> Iterator[LegSelection]:
    """The legs chosen for each guide, shown once or more often; not hurried: the gyro is read at the samples."""
    for guide in GUIDES:
        before = None if task.before is None else _carried(task.before, guide)
        search = RouteSearch(replace(task, knowledge=guide, before=before), time_s)
        if before is None:
            search.improve(time_s)
        best = search.best(time_s)
        found = replace(best, task=task, error=np.inf)
        yield found
        for times in TIMES if np.isfinite(best.error) else ():
            again = _again(found, times) if times * len(found.legs) <= MOST_LEGS else None
            if again is None:
                break
            yield again


def _again(choice: LegSelection, times: int) -> LegSelection | None:
    """The legs so often in the same time, and the error that they promise; None where turning takes longer."""
    legs = fitted(choice.task, choice.legs * times, choice.time_s)
    if legs is None:
        return None
    again = replace(choice, legs=legs)
    return replace(again, error=choice.task.error_with(again.information))


def _carried(before: Array, guide: str) -> Array:
    """Information on a symmetric S as that on a guide's entries (k, k), two across the diagonal by their mean."""
    places = PLACES[guide]
    into = np.zeros((len(before), 3 + len(places)))
    into[:3, :3] = np.eye(3)
    for k, (i, j) in enumerate(places):
        across = sum(other in places for other in {(i, j), (j, i)})
        into[3 + SYMMETRIC.index((min(i, j), max(i, j))), 3 + k] = 1.0 / across
    return np.asarray(into.T @ before @ into)
