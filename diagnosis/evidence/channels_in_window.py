"""Channels that are on, or off, only within a window."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from diagnosis.library.drivers import find_drivers
from diagnosis.problem.blocks import Cut
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array


def channels_on_within(problem: LinearProblem, window: tuple[float, float]) -> tuple[str, ...]:
    """Names of recorded channels that are on, or off, only within a window (s)."""
    return courses_on_within(problem, window, ((driver.name, driver.x) for driver in find_drivers(problem)))


def courses_on_within(
    problem: LinearProblem, window: tuple[float, float], several: Iterable[tuple[str, Array]]
) -> tuple[str, ...]:
    """Names of courses (n,) that are on, or off, only within a window (s)."""
    cut = Cut.of(len(problem.recording), problem.state.interval_s, problem.policy)
    time_s, (begin_s, end_s) = problem.state.time_s, window
    acts = cut.means(((time_s >= begin_s) & (time_s < end_s)).astype(float))
    return tuple(name for name, x in several if correlation(acts, cut.means(x)) > problem.policy.nearly_all)


def correlation(first: Array, second: Array) -> float:
    """``|r|`` of courses (m,); 0 for a constant course."""
    return abs(float(np.corrcoef(first, second)[0, 1])) if np.ptp(first) > 0 and np.ptp(second) > 0 else 0.0
