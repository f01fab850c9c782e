"""Channels beside a residual: held-out shares that they explain, and channels that act in a window alone."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from typing import NamedTuple

import numpy as np

from diagnosis.evidence.baseline import Baseline
from diagnosis.library.drivers import CHANNEL_LAGS, Driver, find_drivers
from diagnosis.policy import Policy
from diagnosis.problem.blocks import Cut
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.sensors import as_currents
from scenarios.arrays import Array
from sim.rotation import matrix_from_q

TIME = "time_s"
"""Name of time as a channel: every slow disturbance is correlated with time."""


class ChannelShare(NamedTuple):
    """A channel, the frame ("body", "earth", "strength"), and the channel's share of the gap on held-out data."""

    channel: str
    frame: str
    share: float


def localise(problem: LinearProblem, residual: Array) -> tuple[ChannelShare, ...]:
    """Channels in order of the share of the residual's slow power (n, q) that bin means explain on held-out data."""
    n, policy = len(residual), problem.policy
    length = max(1, min(round(policy.channel_mean_s / problem.state.interval_s), n // policy.least_channel_means))
    cut = Cut(length, n // length)
    mean = cut.means(residual)
    frames = {"body" if problem.mode == "vector" else problem.compared: mean}
    if problem.mode == "vector":
        R = problem.state.R_wb[: cut.m * length : length]
        frames["earth"] = np.einsum("nij,nj->ni", R, mean)
    again = set(as_currents(problem.recording).values())
    best: dict[str, ChannelShare] = {}
    for name, values in channels(problem):
        if name not in again:
            shares = {frame: explained_share(cut.means(values), framed, policy) for frame, framed in frames.items()}
            best[name] = max((ChannelShare(name, *one) for one in shares.items()), key=lambda one: one.share)
    found = sorted((one for one in best.values() if one.share > policy.least_channel_share), key=lambda one: -one.share)
    return tuple(found[: policy.most_channels])


def channels(problem: LinearProblem) -> Iterator[tuple[str, Array]]:
    """Name and values (n,) of every quantity that may drive a disturbance."""
    recording, state = problem.recording, problem.state
    yield TIME, state.time_s
    yield from zip(("field_x", "field_y", "field_z"), state.field_nT.T, strict=True)
    if "rate" in problem.inputs:
        yield from zip(("rate_x", "rate_y", "rate_z"), state.rate_rad_s.T, strict=True)
    if recording.att_q is not None:
        R_wb = matrix_from_q(np.ascontiguousarray(recording.att_q))
        yield "heading", np.arctan2(R_wb[:, 1, 0], R_wb[:, 0, 0])
        up = R_wb[:, 2]
    else:
        up = None if problem.level is None else -problem.level.down
    if up is not None:
        yield "pitch", np.arcsin(np.clip(-up[:, 0], -1, 1))
        yield "roll", np.arctan2(up[:, 1], up[:, 2])
    if recording.pos_enu_m is not None:
        yield from zip(("pos_east_m", "pos_north_m", "pos_up_m"), recording.pos_enu_m.T, strict=True)
    yield from state.channels.items()


def explained_share(channel: Array, residual: Array, policy: Policy) -> float:
    """Held-out share of the squares of a residual (m, q) that bin means of a channel (m,) explain."""
    edges = np.unique(np.quantile(channel, np.linspace(0, 1, policy.channel_bins + 1)[1:-1]))
    before = float((residual**2).sum())
    if not np.isfinite(channel).all() or len(edges) < 2 or not before:
        return 0.0
    place = np.searchsorted(edges, channel)
    fold, after = np.arange(len(channel)) * policy.channel_segments // len(channel) % 2, 0.0
    for held in (fold == 0, fold == 1):
        trained = np.eye(len(edges) + 1)[place[~held]]
        means = trained.T @ residual[~held] / np.maximum(trained.sum(axis=0), 1)[:, None]
        after += float(((residual[held] - means[place[held]]) ** 2).sum())
    return 1 - after / before


def find_followed_channel(start: Baseline, names: Collection[str]) -> ChannelShare | None:
    """The named channel that the base follows best, at once or with a lag; None without channels or attitude.

    Columns ``B (x) (u, u^2, ...)`` on every axis, u the channel with a lag, up to the power `followed_order`; the lag
    is selected with the first power alone.
    """
    problem = start.problem
    known = [one for one in find_drivers(problem) if one.name in names]
    if not known or problem.mode != "vector":
        return None
    each = [(one.name, terms) for one in known for terms in lagged_terms(problem, one)]
    channel, terms = max(each, key=lambda one: start.evidence_of(_times(problem.base, one[1][:, :1])))
    end, train = start.with_columns(_times(problem.base, terms)), ~start.splits[0]
    test = start.held_out_samples() & (problem.usable > 0)
    before, after = (float((baseline.residual(train)[test] ** 2).mean()) for baseline in (start, end))
    return ChannelShare(channel, "body", (before - after) / max(before - 1, 1e-9))


def lagged_terms(problem: LinearProblem, driver: Driver) -> Iterator[Array]:
    """Powers (n, j) of a channel up to `followed_order`, at once and with each lag."""
    for way in CHANNEL_LAGS[:: problem.policy.followed_lags]:
        yield driver.terms(way, problem.state.interval_s)[:, : problem.policy.followed_order]


def _times(base: Array, terms: Array) -> Array:
    """Columns (n, 3, 3 p j): the base (n, p) of each axis times terms (n, j)."""
    return np.asarray(np.einsum("np,nj,ab->napjb", base, terms, np.eye(3)).reshape(len(base), 3, -1))


def courses_on_within(
    problem: LinearProblem, window: tuple[float, float], several: Iterable[tuple[str, Array]] | None = None
) -> tuple[str, ...]:
    """Names of courses (n,), by default of the recorded channels, that are on, or off, only within a window (s)."""
    courses = ((driver.name, driver.x) for driver in find_drivers(problem)) if several is None else several
    cut = Cut.of(len(problem.recording), problem.state.interval_s, problem.policy)
    time_s, (begin_s, end_s) = problem.state.time_s, window
    acts = cut.means(((time_s >= begin_s) & (time_s < end_s)).astype(float))
    return tuple(name for name, x in courses if correlation(acts, cut.means(x)) > problem.policy.nearly_all)


def correlation(first: Array, second: Array) -> float:
    """``|r|`` of courses (m,); 0 for a constant course."""
    return abs(float(np.corrcoef(first, second)[0, 1])) if np.ptp(first) > 0 and np.ptp(second) > 0 else 0.0
