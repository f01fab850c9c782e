"""The limit of tilts for a vehicle that tilts by pushing alone and stays in its place: its pushes cancel out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from scenarios.arrays import Array
from validation.bound.experiment import Experiment
from validation.bound.goal import OFFSET, Goal
from validation.bound.limit import Limit, Tilts, candidates, felt, optimal

Places = NDArray[np.int64]
GAP = 3e-3
"""The design is done when no other can be better by more than this share."""
MOST_ROUNDS = 100
"""Mixtures that are added, one a round; ten or so are enough."""
RARE = 1e-5
"""Weight, in units of the largest, below which a mixture is left out."""


def staying_limit(
    known: Experiment, knowledge: str, tilts: Tilts, goal: Goal = OFFSET, before: Array | None = None
) -> Limit:
    """A-optimal design as in `limit`, for designs whose pushes cancel out: sum_k w_k z_k,xy / z_k,z = 0.

    At a constant height the thrust along the body's z axis pushes by g z_xy / z_z. Speeds that stay bounded have, on
    the average of a long time, no acceleration; drag, where it is not the same to and fro, is left out, and so are
    climbs and falls. The condition is linear in the weights, so that the problem stays convex. Tilts below 90 degrees.
    Raises InputError as `limit` does.
    """
    attitudes, rows = candidates(known, knowledge, tilts)
    up, mirrored = attitudes.as_matrix()[:, :, 2], _mirrored(tilts.angles_deg())
    pushes = np.asarray(up[:, :2] / up[:, 2:])
    variance, gap, weights = balanced(rows, goal.factor(known, knowledge), pushes, mirrored, before)
    return Limit(tilts, goal, float(np.sqrt(variance)), gap, attitudes, weights)


def balanced(
    rows: Array, wanted: Array, moments: Array, mirrored: Places, before: Array | None = None
) -> tuple[float, float, Array]:
    """As `optimal`, of weights with sum_k w_k moments_k = 0, moments (m, q); mirrored (m,): who has the opposite ones.

    Such weights mix balanced ones of at most q + 1 candidates each. From pairs of mirrors on the mixture that gains
    most, a linear programme's answer, joins them until none gains: with d_k as there no balanced design is below
    f^2 / (f + max_v sum_k v_k d_k - sum_k w_k d_k), v balanced.
    """
    pairs, several = np.flatnonzero(mirrored >= np.arange(len(rows))), moments.shape[1] + 1
    mixtures = _Mixtures(
        np.column_stack([pairs, mirrored[pairs], *[pairs] * (several - 2)]),
        np.tile(np.array([0.5, 0.5] + [0.0] * (several - 2)), (len(pairs), 1)),
    )
    for _ in range(MOST_ROUNDS):
        mix = optimal(mixtures.rows(rows), wanted, before)[2]
        weights = mixtures.weights(mix, len(rows))
        variance, slope = felt(rows, weights, wanted, before)
        if not np.isfinite(variance):
            return np.inf, 0.0, weights
        best = _most(slope, moments)
        gap = max(1.0 - float(np.sqrt(variance / (variance + (best - weights) @ slope))), 0.0)
        if gap < GAP:
            break
        mixtures = mixtures.joined(mix > RARE * mix.max(), best)
    return variance, gap, weights


@dataclass(frozen=True, eq=False)
class _Mixtures:
    """Balanced designs: candidates at places (n, s) in shares (n, s)."""

    places: Places
    shares: Array

    def rows(self, rows: Array) -> Array:
        """What each tells, rows (n, s r, k), by those of the candidates (m, r, k)."""
        own = rows[self.places] * np.sqrt(self.shares)[:, :, None, None]
        return np.asarray(own.reshape(len(self.places), -1, rows.shape[2]))

    def weights(self, mix: Array, count: int) -> Array:
        """Of the candidates (m,), the designs in shares mix (n,)."""
        found = np.zeros(count)
        np.add.at(found, self.places, mix[:, None] * self.shares)
        return found

    def joined(self, kept: NDArray[np.bool_], best: Array) -> _Mixtures:
        """Those that are kept, and one more by its weights (m,)."""
        places = np.argsort(-best)[: self.places.shape[1]]
        shares = best[places] / best[places].sum()
        return _Mixtures(
            np.concatenate([self.places[kept], places[None]]), np.concatenate([self.shares[kept], shares[None]])
        )


def _most(slope: Array, moments: Array) -> Array:
    """Balanced weights (m,) whose slope is the largest; at most q + 1 are not zero."""
    conditions = np.vstack([np.ones(len(slope)), moments.T])
    sums = np.eye(len(conditions))[0]
    return np.asarray(linprog(-slope / slope.max(), A_eq=conditions, b_eq=sums, method="highs-ds").x)


def _mirrored(angles_deg: Array) -> Places:
    """Of each attitude (m, 3) the place of that with the opposite pitch and roll."""
    angles, found = np.round(angles_deg, 6), np.empty(len(angles_deg), dtype=np.int64)
    found[np.lexsort((angles * np.array([1.0, -1.0, -1.0])).T)] = np.lexsort(angles.T)
    return found
