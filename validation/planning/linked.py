"""Manoeuvres for methods with a gyro, which links the samples: legs in repeated order."""

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
"""Knowledge for the choice of legs: a good gyro gives the attitude, a poor gyro leaves only the strength."""
TIMES = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32)
"""Numbers of repetitions of the legs: gyro noise accumulates, so turns in quick succession give more information."""
MOST_LEGS = 1000
"""Legs at most of a phase."""
LEAST_S = 100.0
"""Least time for a target, since the gyro's bias is estimated too."""
CLOSE = 1.03
"""Ratio of times at which the search for the shortest ends."""


def linked(task: PlanningTask, time_s: float) -> LegSelection:
    """Return the best selection for a time, by the bound of the intended attitudes; infinite error if unobservable."""
    return min(_tried(task, time_s), key=lambda one: one.error)


def shortest(task: PlanningTask, target: float, most_s: float) -> LegSelection:
    """Return the shortest selection that meets the target, by bisection; the best within most_s if none does."""
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
    """Yield legs for each of GUIDES, repeated TIMES; turns are not faster, since the gyro is sampled."""
    for guide in GUIDES:
        before = None if task.before is None else _carried(task.before, guide)
        search = RouteSearch(replace(task, knowledge=guide, before=before), time_s)
        search.improve(time_s)
        best = search.best(time_s)
        found = replace(best, task=task, error=np.inf)
        yield found
        for times in TIMES if np.isfinite(best.error) and len(best.legs) > 1 else ():
            again = _again(found, times) if times * len(found.legs) <= MOST_LEGS else None
            if again is None:
                break
            yield again


def _again(choice: LegSelection, times: int) -> LegSelection | None:
    """Return the legs repeated within the time, with predicted error; None if turning takes longer."""
    legs = fitted(choice.task, choice.legs * times, choice.time_s)
    if legs is None:
        return None
    again = replace(choice, legs=legs)
    return replace(again, error=choice.task.error_with(again.information))


def _carried(before: Array, guide: str) -> Array:
    """Return information (k, k) on a guide's entries from a symmetric S; the mean of entries across the diagonal."""
    places = PLACES[guide]
    into = np.zeros((len(before), 3 + len(places)))
    into[:3, :3] = np.eye(3)
    for k, (i, j) in enumerate(places):
        across = sum(other in places for other in {(i, j), (j, i)})
        into[3 + SYMMETRIC.index((min(i, j), max(i, j))), 3 + k] = 1.0 / across
    return np.asarray(into.T @ before @ into)
