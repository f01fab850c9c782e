"""Smooth courses as rivals of a window: an effect that grows with time or a channel is largest in a part of the run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.localise import TIME
from diagnosis.library.candidates import Candidate
from diagnosis.library.drivers import AT_ONCE, CHANNEL_LAGS, Driver, find_drivers
from diagnosis.problem.blocks import Cut
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects.parameters import ACTIVE_WINDOW


def equivalent_course(baseline: Baseline, candidate: Candidate) -> str:
    """Name of the time or channel course that explains a windowed candidate as well; empty without any.

    The candidate's columns times powers of time, or times a channel with a lag, against the columns in the window, on
    held-out segments. A channel that is on only in the window must be better by the margin: an equal gain is the window
    by a different name.
    """
    if candidate.window is None:
        return ""
    problem = baseline.problem
    apart, alike = problem.policy.apart, channels_on_within(problem, candidate.window)
    plain = candidate.at({ACTIVE_WINDOW.name: None}).columns(problem)
    grown = (
        (baseline.evidence_of(_times(plain, terms)) + (-apart if name in alike else apart), name)
        for name, terms in _courses(problem)
    )
    nats, name = max(grown, default=(-np.inf, ""))
    return name if nats > baseline.evidence_of(candidate.columns(problem)) else ""


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
    return tuple(name for name, x in several if correlation(acts, cut.means(x)) > problem.policy.one_course)


def correlation(first: Array, second: Array) -> float:
    """``|r|`` of courses (m,); 0 for a constant course."""
    return abs(float(np.corrcoef(first, second)[0, 1])) if np.ptp(first) > 0 and np.ptp(second) > 0 else 0.0


def _courses(problem: LinearProblem) -> Iterator[tuple[str, Array]]:
    """Names and terms (n, j): the powers of time, and every channel with each lag."""
    ways = CHANNEL_LAGS[:: problem.policy.followed_lags]
    interval_s, time = problem.state.interval_s, Driver.of(TIME, problem.state.time_s, problem.policy)
    if time is not None:
        yield TIME, time.terms(AT_ONCE, interval_s)
    yield from ((driver.name, driver.terms(way, interval_s)[:, :1]) for driver in find_drivers(problem) for way in ways)


def _times(columns: Array, terms: Array) -> Array:
    """Columns (n, q, k + k j): unchanged, and times each of the terms (n, j)."""
    return np.concatenate([columns, *(columns * term[:, None, None] for term in terms.T)], axis=2)
