"""Hard and soft iron from strength and dip, by which rotations against the vertical are observable too."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from diagnosis.policy import Policy
from diagnosis.problem.iron_fit import SETTLED, Iron, fit_iron, unit_of
from diagnosis.problem.level import dip_rad, upright
from scenarios.arrays import Array

FIELD_ERROR_RAD = 0.02
"""Standard deviation of a given field's dip: a prior."""


def fit_iron_by_dip(
    measured_nT: Array, strength_nT: Array, down: Array, given_rad: Array, block: int, policy: Policy
) -> Iron:
    """Iron for measurements m (n, 3) with strength F (n,) and dip I (n,), down (n, 3) being a unit vector:

    ``min sum (|h| - F)^2 / v + F^2 (dip(h) - I - c)^2 / w + prior``, ``h = M (m - o)``, c a constant error of the given
    dip. M (3, 3) need not be symmetric; v, w and outliers: see `iron_fit.fit_iron`.
    """
    unit, middle_nT = unit_of(measured_nT, strength_nT, policy)
    task = ByDip(measured_nT * (unit / middle_nT), strength_nT / middle_nT, down, given_rad, policy)
    theta = fit_iron(task, block, policy)
    return Iron(theta[:9].reshape(3, 3) * unit, theta[9:12] * middle_nT / unit)


@dataclass(frozen=True, eq=False)
class ByDip:
    """``|h| - F`` and ``F (dip(h) - I - c)`` of ``h = M (y - o)``: nine elements of M, three of o, and c."""

    y: Array
    F: Array
    down: Array
    given_rad: Array
    policy: Policy

    @property
    def prior_mean(self) -> Array:
        """Unit matrix, no offset, no dip error."""
        return np.concatenate([np.eye(3).ravel(), np.zeros(4)])

    @property
    def prior_std(self) -> Array:
        """Standard deviations (13,) of the nine elements, the offset and the dip error."""
        return np.repeat([self.policy.matrix_prior, self.policy.offset_prior, FIELD_ERROR_RAD], [9, 3, 1])

    def residual(self, theta: Array) -> Array:
        """Residuals (n, 2) of strength and dip."""
        h = (self.y - theta[9:12]) @ theta[:9].reshape(3, 3).T
        off_rad = dip_rad(h, self.down) - self.given_rad - theta[12]
        return np.column_stack([np.linalg.norm(h, axis=1) - self.F, self.F * off_rad])

    def jacobian(self, theta: Array) -> Array:
        """Derivatives (n, 2, 13) of the residuals."""
        matrix, from_offset = theta[:9].reshape(3, 3), self.y - theta[9:12]
        h = from_offset @ matrix.T
        size = np.maximum(np.linalg.norm(h, axis=1, keepdims=True), SETTLED)
        along = np.stack([h / size, upright(h / size, self.down) * (self.F[:, None] / size)], axis=1)
        elements = (along[:, :, :, None] * from_offset[:, None, None, :]).reshape(len(h), 2, 9)
        of_dip = np.zeros((len(h), 2, 1))
        of_dip[:, 1, 0] = -self.F
        return np.concatenate([elements, -along @ matrix, of_dip], axis=2)
