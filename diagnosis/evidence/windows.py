"""From when to when an effect acts: the window in which its columns explain most, of all that a recording has."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from diagnosis.evidence.binned_rows import BinnedRows
from scenarios.arrays import Array

Places = NDArray[np.int64]
NOTHING = 1e-9
"""Part of a column's power below which a window holds none of it but the rounding of the sums."""


class Span(NamedTuple):
    """A window in s of the run, the nats that columns gain in it, and what they gain in the whole run."""

    from_s: float
    to_s: float
    gain: float
    whole_gain: float


@dataclass(frozen=True, eq=False)
class Timeline:
    """Rows in which windows are compared, beside white noise.

    Q (n q, r): what base and effects already in span, orthonormal; left (n, q): what they leave.
    """

    rows: BinnedRows
    Q: Array
    left: Array

    @classmethod
    def of(cls, rows: BinnedRows, inside: Array) -> Timeline:
        """The timeline of rows, with effects' columns (n, q, k) in."""
        n, q, _ = rows.base.shape
        known = np.concatenate([_of_all(rows), inside.reshape(n * q, -1)], axis=1)
        Q = np.linalg.qr(known)[0]
        y = rows.target.reshape(-1)
        return cls(rows, Q, (y - Q @ (Q.T @ y)).reshape(n, q))

    def best(self, columns: Array) -> Span:
        """The window in which columns (n, q, k) explain most; its ends are looked for ever finer, at last by rows.

        Gain of a window w: ``r^T S^-1 r / 2``, ``r = E_w^T y``, ``S = E_w^T E_w - E_w^T Q Q^T E_w``, from sums over
        cells between the ends that are tried.
        """
        n, policy = len(self.left), self.rows.policy
        cells = np.unique(np.linspace(0, n, policy.window_cells + 1).astype(np.int64))
        low, high, gain, whole = self._search(columns, cells, cells, int(policy.least_window * n))
        step = n // policy.window_cells
        while step >= 1:
            step //= policy.window_finer
            lows, highs = (around(at, step, n, policy.window_finer) for at in (low, high))
            low, high, gain, _ = self._search(columns, lows, highs, 1)
        ends = np.append(self.rows.row_s, self.rows.time_s[-1] + self.rows.interval_s)
        return Span(float(ends[low]), float(ends[high]), gain, whole)

    def gain(self, columns: Array, span: Span) -> float:
        """What columns gain in a window that is given."""
        low, high = np.searchsorted(self.rows.row_s, [span.from_s, span.to_s])
        return self._search(columns, np.array([low]), np.array([high]), 1)[2]

    def _search(self, columns: Array, lows: Places, highs: Places, shortest: int) -> tuple[int, int, float, float]:
        """Rows between which the gain is greatest, that gain, and the whole run's."""
        n = len(columns)
        edges = np.unique(np.concatenate([lows, highs, [0, n]]))
        sums = self._sums(columns, edges)
        i, j = (a.ravel() for a in np.meshgrid(*(np.searchsorted(edges, one) for one in (lows, highs)), indexing="ij"))
        wide = edges[j] - edges[i] >= max(shortest, 1)
        i, j = np.append(i[wide], 0), np.append(j[wide], len(edges) - 1)
        gains = _gains(sums[j] - sums[i], self.Q.shape[1])
        best = int(np.argmax(gains))
        return int(edges[i[best]]), int(edges[j[best]]), float(gains[best]), float(gains[-1])

    def _sums(self, columns: Array, edges: Places) -> Array:
        """Products (m, k, r + 1 + k) of columns with Q, what is left and themselves, up to each edge."""
        n, q, k = columns.shape
        others = np.concatenate([self.Q.reshape(n, q, -1), self.left[:, :, None], columns], axis=2)
        width = others.shape[2]
        parts = [columns[a:b].reshape(-1, k).T @ others[a:b].reshape(-1, width) for a, b in itertools.pairwise(edges)]
        return np.concatenate([np.zeros((1, k, width)), np.cumsum(parts, axis=0)])


def _of_all(rows: BinnedRows) -> Array:
    """The base of all outputs (n q, .): one output after the other, or with the coefficients in common."""
    n, q, p = rows.base.shape
    if rows.common:
        return rows.base.reshape(n * q, p)
    base = np.zeros((n, q, q, p))
    for a in range(q):
        base[:, a, a] = rows.base[:, a]
    return base.reshape(n * q, q * p)


def around(at: int, step: int, n: int, count: int) -> Places:
    """Rows about a row, some steps to each side."""
    return np.unique(np.clip(at + max(step, 1) * np.arange(-count, count + 1), 0, n))


def _gains(sums: Array, r: int) -> Array:
    """Gains (m,) of windows from their products (m, k, r + 1 + k) of columns with Q, the target and themselves.

    The last is the whole run, beside which a column that is nearly zero in a window is a difference of rounded sums.
    """
    EQ, Ey, EE = sums[:, :, :r], sums[:, :, r], sums[:, :, r + 1 :]
    S = EE - EQ @ EQ.transpose(0, 2, 1)
    power = np.einsum("mkk->mk", EE)
    size = np.sqrt(np.maximum(power, NOTHING * power[-1] + 1e-300))
    scaled = S / (size[:, :, None] * size[:, None, :]) + 1e-6 * np.eye(S.shape[1])
    target = (Ey / size)[:, :, None]
    return np.asarray((target.transpose(0, 2, 1) @ np.linalg.solve(scaled, target))[:, 0, 0] / 2)
