"""Allocation of time to legs, for the least error of the goal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, minimize

from scenarios.arrays import Array
from validation.bound.limit import inverse

MOST_ROUNDS = 200
PRECISION = 1e-9
"""Change of ln f at which the search stops."""


@dataclass(frozen=True, eq=False)
class LegInformation:
    """Information of legs: ``M(x) = fixed + sum_l x_l each_l``, fixed (k, k), each (m, k, k) for one unit.

    wanted : B (k, q) of the goal; least : lower limit of every x_l; unit_s : time of a unit
    """

    fixed: Array
    each: Array
    wanted: Array
    least: float
    unit_s: float

    def mean_square(self, amounts: Array) -> float:
        """Return ``f = tr B^T M^-1 B``, infinite for singular M."""
        covariance = inverse(self.fixed + np.tensordot(amounts, self.each, 1))
        return np.inf if covariance is None else float(np.sum(self.wanted * (covariance @ self.wanted)))

    def best(self, time_s: float) -> tuple[Array, float]:
        """Return amounts (m,) and f within a time, by SLSQP since ln f is convex; f is infinite for too little time."""
        count, units = len(self.each), time_s / self.unit_s
        if units < self.least * count:
            return np.full(count, self.least), np.inf
        start = np.full(count, units / count)
        if not np.isfinite(self.mean_square(start)):
            return start, np.inf
        found = minimize(
            self._log_and_slope,
            start,
            jac=True,
            method="SLSQP",
            bounds=Bounds(self.least, np.inf),
            constraints=LinearConstraint(np.ones(count), -np.inf, units),
            options={"maxiter": MOST_ROUNDS, "ftol": PRECISION},
        )
        amounts = np.maximum(found.x, self.least)
        return amounts, self.mean_square(amounts)

    def _log_and_slope(self, amounts: Array) -> tuple[float, Array]:
        """Return ln f and the gradient (m,), with ``d f / d x_l = -tr B^T C each_l C B``."""
        covariance = inverse(self.fixed + np.tensordot(amounts, self.each, 1))
        if covariance is None:
            return np.inf, np.zeros(len(amounts))
        sensitivity = covariance @ self.wanted
        size = float(np.sum(self.wanted * sensitivity))
        slope = -np.einsum("iq,lij,jq->l", sensitivity, self.each, sensitivity, optimize=True)
        return float(np.log(size)), np.asarray(slope / size)


def whole(amounts: Array, units: float) -> Array:
    """Return amounts rounded to integers with a sum of at most `units`; largest fractions are rounded up."""
    down = np.maximum(np.floor(amounts), 1.0)
    left = int(units - down.sum())
    raised = np.argsort(down - amounts)[: max(left, 0)]
    down[raised] += 1.0
    return down
