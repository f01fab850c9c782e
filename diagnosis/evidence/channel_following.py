"""Iron, scale or offset that follows a channel: no effect of the library, but a rival of names that explain less."""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

import numpy as np

from diagnosis.evidence.baseline import Baseline
from diagnosis.library.drivers import CHANNEL_LAGS, Driver, Lag, find_drivers
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array


class FollowedChannel(NamedTuple):
    """A channel, and the share of the gap that iron proportional to the channel explains on held-out data."""

    channel: str
    share: float


def find_followed_channel(start: Baseline, names: Collection[str]) -> FollowedChannel | None:
    """The named channel that the base follows best, at once or with a lag; None without channels or attitude.

    Columns ``B (x) (u, u^2, ...)`` on every axis, u the channel with a lag, up to the power `followed_order`; the lag
    is selected with the first power alone.
    """
    problem = start.problem
    ways = CHANNEL_LAGS[:: problem.policy.followed_lags]
    known = [_felt(problem, one, way) for one in find_drivers(problem) if one.name in names for way in ways]
    if not known or problem.mode != "vector":
        return None
    channel, terms = max(known, key=lambda one: start.evidence_of(_times(problem.base, one[1][:, :1])))
    end, train = start.with_columns(_times(problem.base, terms)), ~start.splits[0]
    test = start.held_out_samples() & (problem.usable > 0)
    before, after = (float((baseline.residual(train)[test] ** 2).mean()) for baseline in (start, end))
    return FollowedChannel(channel, (before - after) / max(before - 1, 1e-9))


def _felt(problem: LinearProblem, driver: Driver, way: Lag) -> tuple[str, Array]:
    """Name of a channel and its powers (n, j) with a lag."""
    return driver.name, driver.terms(way, problem.state.interval_s)[:, : problem.policy.followed_order]


def _times(base: Array, terms: Array) -> Array:
    """Columns (n, 3, 3 p j): the base (n, p) of each axis times terms (n, j)."""
    both = (base[:, :, None] * terms[:, None, :]).reshape(len(base), -1)
    return np.asarray(np.einsum("ab,nk->nabk", np.eye(3), both).reshape(len(base), 3, -1))
