"""A window that is none: what grows and shrinks with time or with a channel is at its most in a part of the run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.localise import TIME
from diagnosis.library.candidates import Candidate
from diagnosis.library.drivers import AT_ONCE, EARLY, Driver, drivers
from diagnosis.problem.blocks import Cut
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects.parameters import ACTIVE_WINDOW


def comes_and_goes(ground: Baseline, one: Candidate) -> str:
    """The course with which an effect of a window grows as well, time or a channel: the best; none without a window.

    Its columns times the powers of time, or times a channel with a lag, against those in the window, on held-out
    segments. A channel that is on in the window alone must do better: as well it is the window by another name.
    """
    if one.window is None:
        return ""
    problem = ground.problem
    apart, alike = problem.policy.apart, on_within(problem, one.window)
    plain = one.at({ACTIVE_WINDOW.name: None}).columns(problem)
    grown = (
        (ground.evidence_of(_times(plain, terms)) + (-apart if name in alike else apart), name)
        for name, terms in _courses(problem)
    )
    nats, name = max(grown, default=(-np.inf, ""))
    return name if nats > ground.evidence_of(one.columns(problem)) else ""


def on_within(problem: LinearProblem, window: tuple[float, float]) -> tuple[str, ...]:
    """Recorded channels that are on, or off, in a window (s) and not beside it."""
    return on_in(problem, window, ((one.name, one.x) for one in drivers(problem)))


def on_in(problem: LinearProblem, window: tuple[float, float], several: Iterable[tuple[str, Array]]) -> tuple[str, ...]:
    """Names of those courses (n,) that are on, or off, in a window (s) and not beside it."""
    cut = Cut.of(len(problem.recording), problem.state.interval_s, problem.policy)
    time_s, (begin_s, end_s) = problem.state.time_s, window
    acts = cut.means(((time_s >= begin_s) & (time_s < end_s)).astype(float))
    return tuple(name for name, x in several if correlation(acts, cut.means(x)) > problem.policy.one_course)


def correlation(one: Array, other: Array) -> float:
    """``|r|`` of courses (m,); 0 for one that stands."""
    return abs(float(np.corrcoef(one, other)[0, 1])) if np.ptp(one) > 0 and np.ptp(other) > 0 else 0.0


def _courses(problem: LinearProblem) -> Iterator[tuple[str, Array]]:
    """Time with its powers, and every channel as it is felt: terms (n, j)."""
    ways = EARLY[:: problem.policy.followed_lags]
    interval_s, time = problem.state.interval_s, Driver.of(TIME, problem.state.time_s, problem.policy)
    if time is not None:
        yield TIME, time.terms(AT_ONCE, interval_s)
    yield from ((one.name, one.terms(way, interval_s)[:, :1]) for one in drivers(problem) for way in ways)


def _times(columns: Array, terms: Array) -> Array:
    """Columns (n, q, k + k j): as they are, and times each of terms (n, j)."""
    return np.concatenate([columns, *(columns * term[:, None, None] for term in terms.T)], axis=2)
