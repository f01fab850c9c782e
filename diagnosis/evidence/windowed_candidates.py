"""Candidates limited to a window: effects that explain more in a part of the run than any in the whole run."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.binned_rows import BinnedRows
from diagnosis.evidence.held_out import Evidence, judge_settings
from diagnosis.library.candidates import Candidate, iron_candidates
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects.parameters import ACTIVE_WINDOW

Places = NDArray[np.int64]
NOTHING = 1e-9
"""Part of a column's power below which the content of a window is rounding of the sums."""


class Span(NamedTuple):
    """A window in s, the nats that columns gain in the window, and the nats in the whole run."""

    from_s: float
    to_s: float
    gain: float
    whole_gain: float


def rank_windowed(
    baseline: Baseline, ranking: Sequence[Evidence], listed: dict[str, list[Candidate]]
) -> list[Evidence]:
    """Candidates with their best window, strongest first.

    Only candidates that gain far more in the window than in the whole run. Changes of iron are included: in a part of
    the run the base does not absorb them. Listed settings are compared again within the window.
    """
    problem = baseline.problem
    rows = BinnedRows.of(problem.state.time_s, problem.usable, problem.base, problem.target, problem.policy)
    timeline = Timeline.of(rows, rows.bin_groups(baseline.accepted_columns))
    settings = {name: several[0] for name, several in listed.items()} | {e.name: e.candidate for e in ranking}
    iron = {name: several[0] for name, several in iron_candidates().items()}
    spans = {
        name: (candidate, timeline.best(rows.bin(candidate.columns(problem))))
        for name, candidate in (settings | iron).items()
        if candidate.can_have_window
    }
    worth = {name: pair for name, pair in spans.items() if _is_worth(pair[1], problem.policy)}
    best = sorted(worth, key=lambda name: -worth[name][1].gain)[: problem.policy.tried_coloured]
    found = [_judged(baseline, timeline, listed.get(name, []), *worth[name]) for name in best]
    return [candidate for candidate in found if candidate is not None]


def _is_worth(span: Span, policy: Policy) -> bool:
    return span.gain > policy.coloured_nats and span.whole_gain < policy.window_share * span.gain


def _judged(
    baseline: Baseline, timeline: Timeline, listed: Sequence[Candidate], candidate: Candidate, span: Span
) -> Evidence | None:
    """Evidence of a candidate in its window, with the best of its listed settings there and the window refined."""
    problem, policy = baseline.problem, baseline.problem.policy
    if candidate.effect.search and not candidate.effect.search_role():
        at_span = judge_settings(baseline, [_in(each, span, policy) for each in listed])
        candidate = candidate if at_span is None else at_span.candidate
        plain = candidate.at({ACTIVE_WINDOW.name: None})
        span = timeline.best(timeline.rows.bin(plain.columns(problem)))
    if _is_one_sided(span, problem.state.time_s, policy) and _is_a_jump(timeline, problem, candidate, span):
        return None
    return judge_settings(baseline, [_in(candidate, span, policy)])


def _is_a_jump(timeline: Timeline, problem: LinearProblem, candidate: Candidate, span: Span) -> bool:
    """Whether a constant in the window explains most of a candidate's gain: the signature of a jump."""
    iron = [several[0] for several in iron_candidates().values() if several[0].effect.traits.constant]
    constant = max(timeline.gain(timeline.rows.bin(each.columns(problem)), span) for each in iron)
    return constant > problem.policy.window_share * span.gain


def _in(candidate: Candidate, span: Span, policy: Policy) -> Candidate:
    windows = policy.window_cells * (policy.window_cells + 1) // 2
    return candidate.at({ACTIVE_WINDOW.name: (span.from_s, span.to_s)}, max(candidate.tried, 1) * windows)


def _is_one_sided(span: Span, time_s: Array, policy: Policy) -> bool:
    """Whether a window ends too near an end of the run to leave room for a further window."""
    begin_s, end_s = float(time_s[0]), float(time_s[-1])
    beside_s = min(span.from_s - begin_s, end_s - span.to_s)
    return bool(beside_s < policy.least_window * (end_s - begin_s))


@dataclass(frozen=True, eq=False)
class Timeline:
    """Rows in which windows are compared, under white noise.

    Q (n q, r): orthonormal columns of base and accepted effects; residual (n, q).
    """

    rows: BinnedRows
    Q: Array
    residual: Array

    @classmethod
    def of(cls, rows: BinnedRows, accepted_columns: Array) -> Timeline:
        """The timeline of rows with accepted columns (n, q, k)."""
        known, y = np.concatenate([rows.in_common().base, accepted_columns], axis=2), rows.target.ravel()
        Q = np.linalg.qr(known.reshape(len(y), -1))[0]
        return cls(rows, Q, (y - Q @ (Q.T @ y)).reshape(rows.target.shape))

    def best(self, columns: Array) -> Span:
        """The window in which columns (n, q, k) explain most; the ends are refined down to single rows.

        Gain of a window w: ``r^T S^-1 r / 2``, ``r = E_w^T y``, ``S = E_w^T E_w - E_w^T Q Q^T E_w``, from sums over
        cells between the ends compared.
        """
        n, policy = len(self.residual), self.rows.policy
        cells = np.unique(np.linspace(0, n, policy.window_cells + 1).astype(np.int64))
        low, high, gain, whole = self._search(columns, cells, cells, int(policy.least_window * n))
        step = n // policy.window_cells
        while step >= 1:
            step //= policy.window_finer
            before = -np.inf
            while gain > before:  # the first search has a least length: the ends may be farther than its cells
                before = gain
                lows, highs = (around(at, step, n, policy.window_finer) for at in (low, high))
                low, high, gain, _ = self._search(columns, lows, highs, 1)
        ends = np.append(self.rows.row_start_s, self.rows.time_s[-1] + self.rows.interval_s)
        return Span(float(ends[low]), float(ends[high]), gain, whole)

    def gain(self, columns: Array, span: Span) -> float:
        """Nats that columns gain in a given window."""
        low, high = np.searchsorted(self.rows.row_start_s, [span.from_s, span.to_s])
        return self._search(columns, np.array([low]), np.array([high]), 1)[2]

    def _search(self, columns: Array, lows: Places, highs: Places, shortest: int) -> tuple[int, int, float, float]:
        """First and last row of the window of the largest gain, the gain, and the gain of the whole run."""
        n = len(columns)
        edges = np.unique(np.concatenate([lows, highs, [0, n]]))
        sums = self._sums(columns, edges)
        i, j = (
            a.ravel() for a in np.meshgrid(*(np.searchsorted(edges, rows) for rows in (lows, highs)), indexing="ij")
        )
        wide = edges[j] - edges[i] >= max(shortest, 1)
        i, j = np.append(i[wide], 0), np.append(j[wide], len(edges) - 1)
        gains = _gains(sums[j] - sums[i], self.Q.shape[1])
        best = int(np.argmax(gains))
        return int(edges[i[best]]), int(edges[j[best]]), float(gains[best]), float(gains[-1])

    def _sums(self, columns: Array, edges: Places) -> Array:
        """Products (m, k, r + 1 + k) of columns with Q, residual and themselves, cumulative up to each edge."""
        n, q, k = columns.shape
        others = np.concatenate([self.Q.reshape(n, q, -1), self.residual[:, :, None], columns], axis=2)
        width = others.shape[2]
        parts = [columns[a:b].reshape(-1, k).T @ others[a:b].reshape(-1, width) for a, b in itertools.pairwise(edges)]
        return np.concatenate([np.zeros((1, k, width)), np.cumsum(parts, axis=0)])


def around(at: int, step: int, n: int, count: int) -> Places:
    """Rows around a row, `count` steps to each side."""
    return np.unique(np.clip(at + max(step, 1) * np.arange(-count, count + 1), 0, n))


def _gains(sums: Array, r: int) -> Array:
    """Gains (m,) of windows from products (m, k, r + 1 + k) of columns with Q, target and themselves.

    The last window is the whole run; relative to its power a column that nearly vanishes in a window is rounding of the
    sums.
    """
    EQ, Ey, EE = sums[:, :, :r], sums[:, :, r], sums[:, :, r + 1 :]
    S = EE - EQ @ EQ.transpose(0, 2, 1)
    power = np.einsum("mkk->mk", EE)
    size = np.sqrt(np.maximum(power, NOTHING * power[-1] + 1e-300))
    scaled = S / (size[:, :, None] * size[:, None, :]) + 1e-6 * np.eye(S.shape[1])
    target = (Ey / size)[:, :, None]
    return np.asarray((target.transpose(0, 2, 1) @ np.linalg.solve(scaled, target))[:, 0, 0] / 2)
