"""Candidates limited to a window: effects that explain more in a part of the run than any in the whole run."""

from __future__ import annotations

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
    problem, policy = baseline.problem, baseline.problem.policy
    rows = BinnedRows.of(problem.state.time_s, problem.usable, problem.base, problem.target, policy)
    timeline = Timeline.of(rows, rows.bin_groups(baseline.accepted_columns))
    best_settings = {evidence.name: [evidence.candidate] for evidence in ranking}
    candidates = [several[0] for several in (listed | best_settings | iron_candidates()).values()]
    spans = [(timeline.best(rows.bin(one.columns(problem))), one) for one in candidates if one.can_have_window]
    worth = sorted((pair for pair in spans if _is_worth(pair[0], policy)), key=lambda pair: -pair[0].gain)
    least = worth[0][0].gain - policy.apart if worth else 0.0  # at rest all iron is one constant
    best = [one for i, one in enumerate(worth) if i < policy.tried_coloured or one[0].gain > least]
    found = [_judged(baseline, timeline, listed.get(candidate.name, []), candidate, span) for span, candidate in best]
    return [evidence for evidence in found if evidence is not None]


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
    if _is_one_sided(span, problem.state.time_s, policy) and _is_a_jump(timeline, problem, span):
        return None
    return judge_settings(baseline, [_in(candidate, span, policy)])


def _is_a_jump(timeline: Timeline, problem: LinearProblem, span: Span) -> bool:
    """Whether a constant in the window explains most of a candidate's gain: the signature of a jump."""
    iron = [several[0] for several in iron_candidates().values() if several[0].effect.traits.constant]
    constant = max(timeline.gain(timeline.rows.bin(each.columns(problem)), span) for each in iron)
    return constant > problem.policy.window_share * span.gain


def _in(candidate: Candidate, span: Span, policy: Policy) -> Candidate:
    windows = policy.window_cells * (policy.window_cells + 1) // 2
    return candidate.at({ACTIVE_WINDOW.name: (span.from_s, span.to_s)}, max(candidate.tried, 1) * windows)


def _is_one_sided(span: Span, time_s: Array, policy: Policy) -> bool:
    """Whether a window ends too near an end of the run to leave room for a further window."""
    beside_s = min(span.from_s - float(time_s[0]), float(time_s[-1]) - span.to_s)
    return bool(beside_s < policy.least_window * np.ptp(time_s))


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

        Gain of a window w: ``r^T S^-1 r / 2``, ``r = E_w^T y``, ``S = E_w^T E_w - E_w^T Q Q^T E_w``, from sums up to
        each row.
        """
        n, policy, sums = len(self.residual), self.rows.policy, self._sums(columns)
        cells = np.unique(np.linspace(0, n, policy.window_cells + 1).astype(np.int64))
        low, high, gain, whole = self._search(sums, cells, cells, int(policy.least_window * n))
        step = n // policy.window_cells
        while step >= 1:
            step //= policy.window_finer
            before = -np.inf
            while gain > before:  # the first search has a least length: the ends may be farther than its cells
                before, around = gain, max(step, 1) * np.arange(-policy.window_finer, policy.window_finer + 1)
                lows, highs = (np.unique(np.clip(at + around, 0, n)) for at in (low, high))
                low, high, gain, _ = self._search(sums, lows, highs, 1)
        ends = np.append(self.rows.row_start_s, self.rows.time_s[-1] + self.rows.interval_s)
        return Span(float(ends[low]), float(ends[high]), gain, whole)

    def gain(self, columns: Array, span: Span) -> float:
        """Nats that columns gain in a given window."""
        low, high = np.searchsorted(self.rows.row_start_s, [span.from_s, span.to_s])
        return self._search(self._sums(columns), np.array([low]), np.array([high]), 1)[2]

    def _search(self, sums: Array, lows: Places, highs: Places, shortest: int) -> tuple[int, int, float, float]:
        """First and last row of the window of the largest gain, the gain, and the gain of the whole run."""
        i, j = (ends.ravel() for ends in np.meshgrid(lows, highs, indexing="ij"))
        wide = j - i >= max(shortest, 1)
        i, j = np.append(i[wide], 0), np.append(j[wide], len(sums) - 1)
        gains = _gains(sums[j] - sums[i], self.Q.shape[1])
        best = int(np.argmax(gains))
        return int(i[best]), int(j[best]), float(gains[best]), float(gains[-1])

    def _sums(self, columns: Array) -> Array:
        """Products (n + 1, k, r + 1 + k) of columns with Q, residual and themselves, cumulative up to each row."""
        Q = self.Q.reshape(*self.residual.shape, -1)
        others = np.concatenate([Q, self.residual[:, :, None], columns], axis=2)
        each = columns.transpose(0, 2, 1) @ others
        return np.concatenate([np.zeros((1, *each.shape[1:])), np.cumsum(each, axis=0)])


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
