"""Where an ellipsoid moves: cuts of a record at which separate ellipsoids pay for their parameters."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calib.models.ellipsoid import norm_coordinates, norm_jacobian
from calib.models.norm import norm_rows
from calib.numerics.noise import SECOND, white_noise_std
from calib.result import Calibration
from scenarios.arrays import Array

PARAMETERS = 10
"""What a segment costs: nine of its ellipsoid and the time of its cut."""
NOISE_FLOOR = 1e-9
"""Smallest noise of the residual, as a fraction of the field: rounding."""
RIDGE = 1e-12


@dataclass(frozen=True)
class LinearisedRows:
    """The whole-record fit linearised, in units of the field: r (n,) and q (n, 9) = -dr/d(T, c), over the gain |T u|.

    r_i = |T m_i - c| - 1, so a segment with its own (T + dT, c + dc) leaves r - q d, and its cost is
    sum r^2 - g^T N^-1 g,  N = sum q q^T,  g = sum q r: additive in time, solved for any stretch from running sums.
    """

    r: Array
    q: Array
    centre_rows: Array

    @classmethod
    def of(cls, mag_nT: Array, whole: Calibration, strength_nT: float) -> LinearisedRows:
        """Linearise at a whole-record fit of measurements (n, 3)."""
        middle = mag_nT.mean(axis=0)
        x = (mag_nT - middle) / strength_nT
        T, centre = whole.matrix, (whole.offset_nT - middle) / strength_nT
        p = norm_coordinates(T, T @ centre)
        r, q = norm_rows(p, x)
        u = -q[:, 6:]
        gain = np.linalg.norm(u @ T, axis=1)
        return cls(r / gain, -q / gain[:, None], norm_jacobian(p)[:3])

    def noise_std(self) -> float:
        """White noise of r, in which there is no motion but the ellipsoid's own slow one."""
        return float(np.fmax(white_noise_std(self.r[:, None], orders=SECOND)[0], NOISE_FLOOR))

    def sums(self, edges: NDArray[np.int_]) -> tuple[Array, Array, Array]:
        """Running sums of r^2 (m,), q r (m, 9) and q q^T (m, 9, 9) up to each of m edges."""
        parts = [slice(a, b) for a, b in itertools.pairwise(edges.tolist())]
        squares = np.array([self.r[s] @ self.r[s] for s in parts])
        mixed = np.array([self.q[s].T @ self.r[s] for s in parts])
        normal = np.array([self.q[s].T @ self.q[s] for s in parts])
        return (
            np.concatenate(([0.0], squares.cumsum())),
            np.vstack((np.zeros(9), mixed.cumsum(axis=0))),
            np.concatenate((np.zeros((1, 9, 9)), normal.cumsum(axis=0))),
        )


def find_cuts(rows: LinearisedRows, blocks: int, penalty: float, max_std: float) -> list[int]:
    """Samples at which new segments begin, between block edges first, then to the sample.

    min over cuts of  sum_segments [ cost / sigma^2 + penalty PARAMETERS ln n ]  (Schwarz's criterion at penalty 1),
    by dynamic programming over `blocks` blocks; a segment whose centre would be less certain than `max_std` (fraction
    of the field) in a direction is not allowed. One segment when nothing pays.
    """
    n = len(rows.r)
    edges = np.unique(np.linspace(0, n, min(blocks, n) + 1).astype(int))
    sigma = rows.noise_std()
    costs = _segment_costs(rows, edges, sigma, max_std)
    best, back = np.full(len(edges), np.inf), np.zeros(len(edges), dtype=int)
    best[0] = 0.0
    for end in range(1, len(edges)):
        total = best[:end] + costs[:end, end] + penalty * PARAMETERS * np.log(n)
        back[end] = int(np.argmin(total))
        best[end] = total[back[end]]
    if not np.isfinite(best[-1]):
        return []
    ends = [len(edges) - 1]
    while back[ends[-1]] > 0:
        ends.append(int(back[ends[-1]]))
    return _refined(rows, edges, sorted(ends[1:]))


def _segment_costs(rows: LinearisedRows, edges: NDArray[np.int_], sigma: float, max_std: float) -> Array:
    """Cost over sigma^2 of the stretch between every two edges (m, m); infinite where it is not allowed."""
    squares, mixed, normal = rows.sums(edges)
    i, j = np.triu_indices(len(edges), 1)
    N = normal[j] - normal[i]
    N += RIDGE * np.trace(N, axis1=1, axis2=2)[:, None, None] * np.eye(9)
    g = mixed[j] - mixed[i]
    inverse = np.linalg.inv(N)
    cost = squares[j] - squares[i] - np.einsum("kp,kpq,kq->k", g, inverse, g)
    centre = rows.centre_rows @ inverse @ rows.centre_rows.T
    loose = sigma * np.sqrt(np.linalg.eigvalsh(centre)[:, -1].clip(0)) > max_std
    out = np.full((len(edges), len(edges)), np.inf)
    out[i, j] = np.where(loose, np.inf, cost.clip(0) / sigma**2)
    return out


def _refined(rows: LinearisedRows, edges: NDArray[np.int_], cuts: list[int]) -> list[int]:
    """Each cut moved to the best sample within a block on either side, its neighbours held."""
    bounds = [0, *(int(edges[k]) for k in cuts), len(rows.r)]
    for place, k in enumerate(cuts, start=1):
        low, high = int(edges[k - 1]) + 1, int(edges[k + 1])
        candidates = np.arange(max(low, bounds[place - 1] + 1), min(high, bounds[place + 1]))
        marks = np.concatenate(([bounds[place - 1]], candidates, [bounds[place + 1]]))
        squares, mixed, normal = rows.sums(marks)
        left = _costs(squares, mixed, normal)
        right = _costs(squares[-1] - squares, mixed[-1] - mixed, normal[-1] - normal)
        bounds[place] = int(candidates[np.argmin((left + right)[1:-1])])
    return bounds[1:-1]


def _costs(squares: Array, mixed: Array, normal: Array) -> Array:
    """sum r^2 - g^T N^-1 g (k,)."""
    ridge = (RIDGE * np.trace(normal, axis1=1, axis2=2) + NOISE_FLOOR**2)[:, None, None] * np.eye(9)
    solved = np.linalg.solve(normal + ridge, mixed[:, :, None])[:, :, 0]
    return np.asarray(squares - np.einsum("kp,kp->k", mixed, solved))
