"""Hard and soft iron from the strength of the field: robust, with a weak prior for unobservable directions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from diagnosis.policy import Policy
from diagnosis.problem.iron_fit import SETTLED, Iron, fit_iron, unit_of
from scenarios.arrays import Array

PAIRS = (np.array([0, 1, 2, 0, 0, 1]), np.array([0, 1, 2, 1, 2, 2]))
"""Rows and columns of the six elements of a symmetric matrix."""


def fit_iron_by_strength(measured_nT: Array, strength_nT: Array, block: int, policy: Policy) -> Iron:
    """Iron for measurements m (n, 3) with field strength F (n,): ``min sum (|M (m - o)| - F)^2 / v + prior``.

    M is symmetric; v and outliers: see `iron_fit.fit_iron`. Every motion is accepted: in unobservable directions the
    prior holds, M = 1 and o = 0.
    """
    unit, middle_nT = unit_of(measured_nT, strength_nT, policy)
    task = ByStrength(measured_nT * (unit / middle_nT), strength_nT / middle_nT, policy)
    matrix, offset = parts(fit_iron(task, block, policy))
    return Iron(matrix * unit, offset * middle_nT / unit)


@dataclass(frozen=True, eq=False)
class ByStrength:
    """``|M (y - o)| - F`` of measurements y (n, 3) and strengths F (n,), with nine parameters."""

    y: Array
    F: Array
    policy: Policy

    @property
    def prior_mean(self) -> Array:
        """Unit matrix and no offset."""
        return np.concatenate([np.eye(3)[PAIRS], np.zeros(3)])

    @property
    def prior_std(self) -> Array:
        """Standard deviations (9,) of the six elements and the offset."""
        return np.repeat([self.policy.matrix_prior, self.policy.offset_prior], [6, 3])

    def residual(self, theta: Array) -> Array:
        """Residuals ``|M (y - o)| - F`` (n, 1)."""
        matrix, offset = parts(theta)
        return np.asarray(np.linalg.norm((self.y - offset) @ matrix, axis=1) - self.F)[:, None]

    def jacobian(self, theta: Array) -> Array:
        """Derivatives (n, 1, 9) of the residuals."""
        matrix, offset = parts(theta)
        from_offset = self.y - offset
        h = from_offset @ matrix
        u = h / np.maximum(np.linalg.norm(h, axis=1, keepdims=True), SETTLED)
        first, second = PAIRS
        products = u[:, first] * from_offset[:, second] + (u[:, second] * from_offset[:, first]) * (first != second)
        return np.column_stack([products, -u @ matrix])[:, None]


def parts(theta: Array) -> tuple[Array, Array]:
    """Symmetric matrix (3, 3) and offset (3,) from nine parameters."""
    upper = np.zeros((3, 3))
    upper[PAIRS] = theta[:6]
    return upper + upper.T - np.diag(np.diag(upper)), theta[6:]
