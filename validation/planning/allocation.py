"""How much of each leg: the amounts that make the goal's error least within the time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, minimize

from scenarios.arrays import Array
from validation.bound.limit import inverse

MOST_ROUNDS = 200
PRECISION = 1e-9
"""Change of ln f at which the search ends."""


@dataclass(frozen=True, eq=False)
class LegInformation:
    """What legs tell: M(x) = fixed (k, k) + sum_l x_l each_l, each (m, k, k) of one unit; wanted B (k, q).

    least : of every x_l, which `fixed` leaves out; unit_s : time of a unit
    """

    fixed: Array
    each: Array
    wanted: Array
    least: float
    unit_s: float

    def mean_square(self, amounts: Array) -> float:
        """f = tr B^T M^-1 B; infinite where the legs do not tell it."""
        covariance = inverse(self.fixed + np.tensordot(amounts, self.each, 1))
        return np.inf if covariance is None else float(np.sum(self.wanted * (covariance @ self.wanted)))

    def best(self, time_s: float) -> tuple[Array, float]:
        """Amounts (m,) and f, within so much time for them; f is infinite for too little. ln f is convex: by SLSQP."""
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
        """ln f, and -|..|^2 / f: d f / d x_l = -tr B^T C each_l C B."""
        covariance = inverse(self.fixed + np.tensordot(amounts, self.each, 1))
        if covariance is None:
            return np.inf, np.zeros(len(amounts))
        felt = covariance @ self.wanted
        size = float(np.sum(self.wanted * felt))
        slope = -np.einsum("iq,lij,jq->l", felt, self.each, felt, optimize=True)
        return float(np.log(size)), np.asarray(slope / size)


def whole(amounts: Array, units: float) -> Array:
    """Whole amounts of about these sizes whose sum fits, those cut most raised first."""
    down = np.maximum(np.floor(amounts), 1.0)
    left = int(units - down.sum())
    raised = np.argsort(down - amounts)[: max(left, 0)]
    down[raised] += 1.0
    return down
