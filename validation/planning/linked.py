"""Manoeuvres for a method with a gyro, which links what the samples tell: legs shown again and again."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from scenarios.paths import PhaseBase
from validation.bound.bound import Bound
from validation.bound.experiment import Experiment
from validation.planning.refine import fitted
from validation.planning.search import Choice, Search
from validation.planning.task import Task

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


def linked(task: Task, time_s: float) -> Choice:
    """The best for a time, by the bound along the attitudes as they are meant; its error infinite where none tells."""
    return min(_tried(task, time_s), key=lambda one: one.error)


def shortest(task: Task, target: float, most_s: float) -> Choice:
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


def _tried(task: Task, time_s: float) -> Iterator[Choice]:
    """The legs chosen for each guide, shown once or more often; not hurried: the gyro is read at the samples."""
    for guide in GUIDES:
        search = Search(replace(task, knowledge=guide), time_s)
        search.improve(time_s)
        best = search.best(time_s)
        found = replace(best, task=task, error=np.inf)
        yield found
        for times in TIMES if np.isfinite(best.error) else ():
            again = _again(found, times) if times * len(found.legs) <= MOST_LEGS else None
            if again is None:
                break
            yield again


def _again(choice: Choice, times: int) -> Choice | None:
    """The legs so often in the same time, and the error that they promise; None where turning takes longer."""
    legs = fitted(choice.task, choice.legs * times, choice.time_s)
    if legs is None:
        return None
    known = meant(choice.task, choice.task.manoeuvre.phase(legs))
    told = Bound.of(known, choice.task.knowledge).information.matrix
    return replace(choice, legs=legs, error=choice.task.error(told))


def meant(task: Task, phase: PhaseBase) -> Experiment:
    """The experiment of a phase whose attitudes are as they are meant."""
    attitudes = task.manoeuvre.attitudes(phase, 0.0, phase.duration_s, task.interval_s)
    assert task.known.field_enu_nT is not None
    turns = (attitudes[1:].inv() * attitudes[:-1]).as_matrix()
    return replace(
        task.known,
        field_nT=np.asarray(attitudes.inv().apply(task.known.field_enu_nT)),
        turns=np.asarray(turns),
        step_s=np.full(len(turns), task.interval_s),
        up=None,
    )
