"""Robust least squares of iron with a weak prior: task protocol and Levenberg-Marquardt steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from diagnosis.policy import Policy
from scenarios.arrays import Array

MOST_STEPS, SETTLED = 60, 1e-9
"""Steps at most, and relative change of the cost that ends them; also the size negligible beside the field."""
FIRST_DAMPING, DAMPING_FACTOR = 1e-3, 5.0
"""Damping of the Levenberg-Marquardt steps."""
ROUNDS = 3
"""Number of updates of the residual's colour and of the outliers."""


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


class IronFitTask(Protocol):
    """A least-squares task: parameters theta (p,) with a Gaussian prior, q residuals for each sample."""

    @property
    def prior_mean(self) -> Array:
        """Mean (p,) of the prior, and start of the fit."""

    @property
    def prior_std(self) -> Array:
        """Standard deviation (p,) of the prior."""

    def residual(self, theta: Array) -> Array:
        """Residuals (n, q) in units of the field's strength."""

    def jacobian(self, theta: Array) -> Array:
        """Derivatives (n, q, p) of the residuals by the parameters."""


def unit_of(measured_nT: Array, strength_nT: Array, policy: Policy) -> tuple[float, float]:
    """Factor from the unit of measurements (n, 3) to the unit of strengths (n,), and the median strength."""
    size, middle_nT = (float(np.median(sizes)) for sizes in (np.linalg.norm(measured_nT, axis=1), strength_nT))
    return 1.0 if 1 / policy.clearly_larger < size / middle_nT < policy.clearly_larger else middle_nT / size, middle_nT


def fit_iron(task: IronFitTask, block: int, policy: Policy) -> Array:
    """Parameters theta (p,) of ``min sum_a sum r_a^2 / v_a + prior`` with residuals r (n, q), outliers excluded.

    v (q,) is the power of the residual times its colour over means of `block` samples and more, so that a slow
    disturbance does not bend axes that the motion hardly determines.
    """
    theta = task.prior_mean
    for _ in range(ROUNDS):
        residual = task.residual(theta)
        use = np.column_stack([_near(np.abs(column), policy) for column in residual.T])
        power = [_power(column[near > 0], block, policy) for column, near in zip(residual.T, use.T, strict=True)]
        theta = _minimum(theta, task, use / np.array(power))
    return theta


def _near(off: Array, policy: Policy) -> Array:
    """1 for samples (n,) without outliers; 1 for all samples where outliers are too many."""
    far = off > policy.never_sigma * max(float(np.median(off)), SETTLED)
    return np.ones(len(off)) - far * float(far.mean() < policy.fair_share)


def _power(residual: Array, block: int, policy: Policy) -> float:
    """Power of a residual (n,), times the largest excess of its block means over white noise."""
    power = max(float((residual**2).mean()), SETTLED**2)
    excess = 1.0
    for several in policy.colour_blocks:
        length = several * block
        means = residual[: len(residual) // length * length].reshape(-1, length).mean(axis=1)
        if len(means) >= policy.least_colour_means:
            excess = max(excess, float((means**2).mean()) * length / power)
    return power * excess


def _minimum(theta: Array, task: IronFitTask, weight: Array) -> Array:
    """Parameters of least cost by Levenberg-Marquardt steps; weight (n, q) of each squared residual."""

    def cost(residual: Array, at: Array) -> float:
        return float((weight * residual**2).sum() + (((at - task.prior_mean) / task.prior_std) ** 2).sum())

    residual = task.residual(theta)
    damping, now = FIRST_DAMPING, cost(residual, theta)
    for _ in range(MOST_STEPS):
        J = task.jacobian(theta)
        weighted = (J * weight[:, :, None]).reshape(-1, len(theta))
        normal = weighted.T @ J.reshape(-1, len(theta)) + np.diag(task.prior_std**-2.0)
        downhill = weighted.T @ residual.ravel() + (theta - task.prior_mean) / task.prior_std**2
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
