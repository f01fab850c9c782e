"""Iron, scale or offset that follows a channel: no effect of its own, but a rival of names that explain less."""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

import numpy as np

from diagnosis.evidence.baseline import Baseline
from diagnosis.library.drivers import EARLY, Driver, Way, drivers
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array


class Follows(NamedTuple):
    """A channel and the share of the gap that iron which follows it explains on held-out data."""

    channel: str
    share: float


def iron_follows(start: Baseline, names: Collection[str]) -> Follows | None:
    """Of the channels of these names the one whose course the base follows best, at once or late; None without any.

    ``B (x) (u, u^2, ...)`` on every axis, u the channel as it is felt, to the power `followed_order`; the lag is that
    of the first power.
    """
    problem = start.problem
    ways = EARLY[:: problem.policy.followed_lags]
    known = [_felt(problem, one, way) for one in drivers(problem) if one.name in names for way in ways]
    if not known or problem.mode != "vector":
        return None
    channel, terms = max(known, key=lambda one: start.evidence_of(_times(problem.base, one[1][:, :1])))
    end, train = start.beside(_times(problem.base, terms)), ~start.splits[0]
    test = start.held_samples() & (problem.usable > 0)
    before, after = (float((ground.residual(train)[test] ** 2).mean()) for ground in (start, end))
    return Follows(channel, (before - after) / max(before - 1, 1e-9))


def _felt(problem: LinearProblem, one: Driver, way: Way) -> tuple[str, Array]:
    """A channel's name and its powers (n, j) as it is felt."""
    return one.name, one.terms(way, problem.state.interval_s)[:, : problem.policy.followed_order]


def _times(base: Array, terms: Array) -> Array:
    """Columns (n, 3, 3 p j) of the base (n, p) of each axis times terms (n, j)."""
    both = (base[:, :, None] * terms[:, None, :]).reshape(len(base), -1)
    return np.asarray(np.einsum("ab,nk->nabk", np.eye(3), both).reshape(len(base), 3, -1))
