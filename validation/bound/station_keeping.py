"""Limit of tilts for a vehicle that tilts only by thrust and remains in place: balanced thrust."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from scenarios.arrays import Array
from validation.bound.experiment import Experiment
from validation.bound.goal import OFFSET, Goal
from validation.bound.limit import Limit, Tilts, candidates, criterion, optimal

Places = NDArray[np.int64]
GAP = 3e-3
"""Relative duality gap at which a design is optimal."""
MOST_ROUNDS = 100
"""Mixtures added at most, one a round; about ten suffice."""
RARE = 1e-5
"""Weight over the largest below which a mixture is dropped."""


def staying_limit(
    known: Experiment, knowledge: str, tilts: Tilts, goal: Goal = OFFSET, before: Array | None = None
) -> Limit:
    """Return the A-optimal design as `limit` under balanced thrust: sum_k w_k z_k,xy / z_k,z = 0.

    At constant height the thrust along the body's z axis accelerates by g z_xy / z_z. Bounded speeds have a mean
    acceleration of zero over a long time; asymmetric drag, climbs and falls are neglected. The condition is linear in
    the weights, so the problem remains convex. Tilts below 90 degrees.
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
    """Return optimal weights with sum_k w_k moments_k = 0, moments (m, q).

    mirrored : (m,), index of the candidate with opposite moment.

    Balanced weights are mixtures of balanced designs with at most q + 1 candidates. Starting from pairs of mirrored
    candidates, the mixture with the largest gain (from a linear programme) is added until the gain vanishes. With d_k
    as in `optimal` no balanced design is below f^2 / (f + max_v sum_k v_k d_k - sum_k w_k d_k), v balanced.
    """
    pairs, several = np.flatnonzero(mirrored >= np.arange(len(rows))), moments.shape[1] + 1
    mixtures = _Mixtures(
        np.column_stack([pairs, mirrored[pairs], *[pairs] * (several - 2)]),
        np.tile(np.array([0.5, 0.5] + [0.0] * (several - 2)), (len(pairs), 1)),
    )
    for _ in range(MOST_ROUNDS):
        mix = optimal(mixtures.rows(rows), wanted, before)[2]
        weights = mixtures.weights(mix, len(rows))
        variance, slope = criterion(rows, weights, wanted, before)
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
    """Balanced designs: candidates at places (n, s) with shares (n, s)."""

    places: Places
    shares: Array

    def rows(self, rows: Array) -> Array:
        """Return rows (n, s r, k) of each design from rows (m, r, k) of the candidates."""
        own = rows[self.places] * np.sqrt(self.shares)[:, :, None, None]
        return np.asarray(own.reshape(len(self.places), -1, rows.shape[2]))

    def weights(self, mix: Array, count: int) -> Array:
        """Return weights of the candidates (m,) for designs with shares mix (n,)."""
        found = np.zeros(count)
        np.add.at(found, self.places, mix[:, None] * self.shares)
        return found

    def joined(self, kept: NDArray[np.bool_], best: Array) -> _Mixtures:
        """Return the kept designs and a further design with weights `best` (m,)."""
        places = np.argsort(-best)[: self.places.shape[1]]
        shares = best[places] / best[places].sum()
        return _Mixtures(
            np.concatenate([self.places[kept], places[None]]), np.concatenate([self.shares[kept], shares[None]])
        )


def _most(slope: Array, moments: Array) -> Array:
    """Return the balanced weights (m,) of largest slope; at most q + 1 are not zero."""
    conditions = np.vstack([np.ones(len(slope)), moments.T])
    sums = np.eye(len(conditions))[0]
    return np.asarray(linprog(-slope / slope.max(), A_eq=conditions, b_eq=sums, method="highs-ds").x)


def _mirrored(angles_deg: Array) -> Places:
    """Return for each attitude (m, 3) the index of the attitude with opposite pitch and roll."""
    angles, found = np.round(angles_deg, 6), np.empty(len(angles_deg), dtype=np.int64)
    found[np.lexsort((angles * np.array([1.0, -1.0, -1.0])).T)] = np.lexsort(angles.T)
    return found
