"""Hard and soft iron from the strength of the field, or from strength and dip: robust, with a weak prior."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from diagnosis.policy import Policy
from diagnosis.problem.level import Dip, dip_rad, upright
from scenarios.arrays import Array

MOST_STEPS, SETTLED = 60, 1e-9
"""Steps at most, and relative change of the cost that ends them; also the size negligible beside the field."""
FIRST_DAMPING, DAMPING_FACTOR = 1e-3, 5.0
"""Damping of the Levenberg-Marquardt steps."""
ROUNDS = 3
"""Number of updates of the residual's colour and of the outliers."""
LEAST_NOISE = 1e-6
"""Least noise over the field: with less, nothing is left of the prior in the sums of squares."""
DIP_ERROR_RAD = 0.02
"""Standard deviation of a given field's dip: a prior."""


@dataclass(frozen=True)
class Iron:
    """``h = M (m - o)``: matrix M (3, 3) and offset o (3,) in nT."""

    matrix: Array
    offset_nT: Array

    def field_nT(self, measured_nT: Array) -> Array:
        """Corrected field (n, 3)."""
        return np.asarray((measured_nT - self.offset_nT) @ self.matrix.T)

    @property
    def turn(self) -> Array:
        """``M^-1`` (3, 3), from the field to the measurement."""
        return np.asarray(np.linalg.inv(self.matrix), dtype=np.float64)

    def measured_nT(self, field_nT: Array) -> Array:
        """Measurement (n, 3) of a field (n, 3)."""
        return np.asarray(field_nT @ self.turn.T + self.offset_nT)


def fit_iron(measured_nT: Array, strength_nT: Array, time_s: Array, policy: Policy, dip: Dip | None = None) -> Iron:
    """Iron for measurements m (n, 3) at times (n,) with strength F (n,), and dip I (n,) if known; without outliers.

    ``min sum (|h| - F)^2 / v + F^2 (dip(h) - I - c)^2 / w + prior``, ``h = M (m - o)``, c a constant error of the given
    dip. Without a dip M is symmetric: the strength shows no turn. v and w are the power of a residual times its colour
    over means of `block_s` and more, so that a slow disturbance does not bend axes that the motion hardly
    determines. In unobservable directions the prior holds, M = 1 and o = 0.
    """
    unit, middle_nT = unit_of(measured_nT, strength_nT, policy)
    task = IronFit(measured_nT * (unit / middle_nT), strength_nT / middle_nT, policy, dip)
    theta, block = task.prior_mean, max(1, round(policy.block_s / float(np.median(np.diff(time_s)))))
    for _ in range(ROUNDS):
        residual = task.residual(theta)
        use = np.column_stack([_near(np.abs(column), policy) for column in residual.T])
        power = [_power(column[near > 0], block, policy) for column, near in zip(residual.T, use.T, strict=True)]
        theta = _minimum(theta, task, use / np.array(power))
    matrix = theta[:9].reshape(3, 3)
    if dip is None:
        _, size, axes = np.linalg.svd(matrix)
        matrix = (axes.T * size) @ axes
    return Iron(matrix * unit, theta[9:12] * middle_nT / unit)


def unit_of(measured_nT: Array, strength_nT: Array, policy: Policy) -> tuple[float, float]:
    """Factor from the unit of measurements (n, 3) to the unit of strengths (n,), and the median strength."""
    size, middle_nT = (float(np.median(sizes)) for sizes in (np.linalg.norm(measured_nT, axis=1), strength_nT))
    return 1.0 if 1 / policy.clearly_larger < size / middle_nT < policy.clearly_larger else middle_nT / size, middle_nT


@dataclass(frozen=True, eq=False)
class IronFit:
    """Residuals ``|h| - F`` and ``F (dip(h) - I - c)`` of ``h = M (y - o)``, in units of the field's strength.

    Parameters theta (p,): nine elements of M, three of o, and c where a dip is known; Gaussian prior.
    """

    y: Array
    F: Array
    policy: Policy
    dip: Dip | None = None

    @property
    def prior_mean(self) -> Array:
        """Unit matrix, no offset, no dip error."""
        return np.concatenate([np.eye(3).ravel(), np.zeros(3 if self.dip is None else 4)])

    @property
    def prior_std(self) -> Array:
        """Standard deviations (p,) of the parameters."""
        of_each = np.repeat([self.policy.matrix_prior, self.policy.offset_prior, DIP_ERROR_RAD], [9, 3, 1])
        return of_each[: len(self.prior_mean)]

    def residual(self, theta: Array) -> Array:
        """Residuals (n, q)."""
        h = (self.y - theta[9:12]) @ theta[:9].reshape(3, 3).T
        off = np.linalg.norm(h, axis=1) - self.F
        if self.dip is None:
            return np.asarray(off[:, None])
        return np.column_stack([off, self.F * (dip_rad(h, self.dip.down) - self.dip.given_rad - theta[12])])

    def jacobian(self, theta: Array) -> Array:
        """Derivatives (n, q, p) of the residuals."""
        matrix, from_offset = theta[:9].reshape(3, 3), self.y - theta[9:12]
        h = from_offset @ matrix.T
        size = np.maximum(np.linalg.norm(h, axis=1, keepdims=True), SETTLED)
        along = (h / size)[:, None]
        if self.dip is not None:
            rising = upright(h / size, self.dip.down) * (self.F[:, None] / size)
            along = np.concatenate([along, rising[:, None]], axis=1)
        elements = (along[:, :, :, None] * from_offset[:, None, None, :]).reshape(*along.shape[:2], 9)
        slopes = np.concatenate([elements, -along @ matrix, np.zeros((*along.shape[:2], len(theta) - 12))], axis=2)
        slopes[:, 1:, 12:] = -self.F[:, None, None]
        return slopes


def _near(off: Array, policy: Policy) -> Array:
    """1 for samples (n,) without outliers; 1 for all samples where outliers are too many."""
    far = off > policy.never_sigma * max(float(np.median(off)), SETTLED)
    return np.ones(len(off)) - far * float(far.mean() < policy.fair_share)


def _power(residual: Array, block: int, policy: Policy) -> float:
    """Power of a residual (n,), times the largest excess of its block means over white noise."""
    power = max(float((residual**2).mean()), LEAST_NOISE**2)
    excess = 1.0
    for several in policy.colour_blocks:
        length = several * block
        means = residual[: len(residual) // length * length].reshape(-1, length).mean(axis=1)
        if len(means) >= policy.least_colour_means:
            excess = max(excess, float((means**2).mean()) * length / power)
    return power * excess


def _minimum(theta: Array, task: IronFit, weight: Array) -> Array:
    """Parameters of least cost by Levenberg-Marquardt steps; weight (n, q) of each squared residual."""
    mean, std = task.prior_mean, task.prior_std

    def cost(residual: Array, at: Array) -> float:
        return float((weight * residual**2).sum() + (((at - mean) / std) ** 2).sum())

    residual = task.residual(theta)
    damping, now = FIRST_DAMPING, cost(residual, theta)
    for _ in range(MOST_STEPS):
        J = task.jacobian(theta)
        weighted = (J * weight[:, :, None]).reshape(-1, len(theta))
        normal = weighted.T @ J.reshape(-1, len(theta)) + np.diag(std**-2.0)
        downhill = weighted.T @ residual.ravel() + (theta - mean) / std**2
        step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), downhill)
        moved = task.residual(theta - step)
        then = cost(moved, theta - step)
        if then > now:
            damping *= DAMPING_FACTOR
        else:
            settled = now - then < SETTLED * now
            theta, residual, now, damping = theta - step, moved, then, damping / DAMPING_FACTOR
            if settled:
                break
    return theta
