"""Hard and soft iron from the strength of the field, or from strength and dip: robust, with a weak prior."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from diagnosis.policy import Policy
from diagnosis.problem.motion import Level
from scenarios.arrays import Array

MOST_STEPS, SETTLED = 60, 1e-9
"""Steps at most, and relative change of the cost that ends them: ahead of the valleys that a motion hardly determines.
"""
FIRST_DAMPING, DAMPING_FACTOR = 1e-3, 5.0
"""Damping of the Levenberg-Marquardt steps."""
ROUNDS = 3
"""Number of updates of the residual's colour and of the outliers."""
LEAST_NOISE = 1e-6
"""Least noise over the field: with less, nothing is left of the prior in the sums of squares."""
LEAST_LEVEL = 1e-6
"""Horizontal part of a unit direction below which the direction counts as vertical."""
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


def fit_iron(measured_nT: Array, strength_nT: Array, time_s: Array, policy: Policy, level: Level | None = None) -> Iron:
    """Iron for measurements m (n, 3) at times (n,) with strength F (n,), and dip I (n,) by a level; without outliers.

    ``min sum (|h| - F)^2 / v + F^2 (dip(h) - I - c)^2 / w + prior``, ``h = M (m - o)``, c a constant error of the given
    dip. Without a level M is symmetric: the strength shows no turn. v and w are the power of a residual times its
    colour over means of `block_s` and more, so that a slow disturbance does not bend axes that the motion hardly
    determines. In unobservable directions the prior holds, M = 1 and o = 0.
    """
    unit, middle_nT = unit_of(measured_nT, strength_nT, policy)
    y, F, p = measured_nT * (unit / middle_nT), strength_nT / middle_nT, 12 if level is None else 13
    mean = np.r_[np.eye(3).ravel(), np.zeros(4)][:p]
    std = np.repeat([policy.matrix_prior, policy.offset_prior, DIP_ERROR_RAD], [9, 3, 1])[:p]
    theta, block = mean, max(1, round(policy.block_s / float(np.median(np.diff(time_s)))))
    for _ in range(ROUNDS):
        off = deviations(theta, y, F, level)[0]
        weight = np.column_stack([_weight(column, block, policy) for column in off.T])
        theta = IronFit(y, F, level, weight, mean, std).minimum(theta)
    matrix = theta[:9].reshape(3, 3)
    if level is None:
        _, size, axes = np.linalg.svd(matrix)
        matrix = (axes.T * size) @ axes
    return Iron(matrix * unit, theta[9:12] * middle_nT / unit)


def unit_of(measured_nT: Array, strength_nT: Array, policy: Policy) -> tuple[float, float]:
    """Factor from the unit of measurements (n, 3) to the unit of strengths (n,), and the median strength."""
    size, middle_nT = (float(np.median(sizes)) for sizes in (np.linalg.norm(measured_nT, axis=1), strength_nT))
    return 1.0 if 1 / policy.clearly_larger < size / middle_nT < policy.clearly_larger else middle_nT / size, middle_nT


@dataclass(frozen=True, eq=False)
class IronFit:
    """The sum of squares of `deviations` with weights (n, q), and of a prior with mean and std (p,)."""

    y: Array
    F: Array
    level: Level | None
    weight: Array
    mean: Array
    std: Array

    def normal(self, theta: Array) -> tuple[float, Array, Array]:
        """Cost at parameters (p,), and normal equations: slope (p,) and square (p, p)."""
        off, J = deviations(theta, self.y, self.F, self.level)
        weighted = (J * self.weight[:, :, None]).reshape(-1, len(theta))
        from_mean = (theta - self.mean) / self.std
        cost = float((self.weight * off**2).sum() + from_mean @ from_mean)
        square = weighted.T @ J.reshape(weighted.shape) + np.diag(self.std**-2.0)
        return cost, weighted.T @ off.ravel() + from_mean / self.std, square

    def minimum(self, theta: Array) -> Array:
        """Parameters (p,) of least cost by Levenberg-Marquardt steps."""
        damping, (now, slope, square) = FIRST_DAMPING, self.normal(theta)
        for _ in range(MOST_STEPS):
            further = theta - np.linalg.solve(square + damping * np.diag(np.diag(square)), slope)
            then, *equations = self.normal(further)
            if then > now:
                damping *= DAMPING_FACTOR
                continue
            settled = now - then < SETTLED * now
            theta, now, (slope, square), damping = further, then, equations, damping / DAMPING_FACTOR
            if settled:
                break
        return theta


def deviations(theta: Array, y: Array, F: Array, level: Level | None) -> tuple[Array, Array]:
    """``|h| - F`` and ``F (dip(h) - I - c)`` of ``h = M (y - o)``, in units of the field: (n, q), and slopes (n, q, p).

    Parameters theta (p,): nine elements of M, three of o, and c with a level.
    """
    matrix, from_offset = theta[:9].reshape(3, 3), y - theta[9:12]
    h = from_offset @ matrix.T
    along, off = compared(h, F[:, None], level)
    slopes = np.zeros((*off.shape, len(theta)))
    if level is not None:
        off[:, 1] -= F * theta[12]
        along[:, 1] *= (F / np.linalg.norm(h, axis=1))[:, None]
        slopes[:, 1, 12] = -F
    slopes[:, :, :9] = (along[:, :, :, None] * from_offset[:, None, None, :]).reshape(*off.shape, 9)
    slopes[:, :, 9:12] = -along @ matrix
    return off, slopes


def compared(field: Array, F: Array, level: Level | None) -> tuple[Array, Array]:
    """Directions (n, q, 3) of strength and dip of a field (n, 3), and their deviations (n, q) from those given.

    F (n, 1): strength in the field's unit; the dip's deviation is an angle times the strength.
    """
    size = np.linalg.norm(field, axis=1, keepdims=True)
    direction = field / np.maximum(size, LEAST_LEVEL * F)
    if level is None:
        return direction[:, None], size - F
    off = np.column_stack([size - F, F[:, 0] * (dip_rad(field, level.down) - level.dip_rad)])
    return np.stack([direction, upright(direction, level.down)], axis=1), off


def dip_rad(field: Array, down: Array) -> Array:
    """Angle (n,) of fields (n, 3) below the horizontal, with unit vectors down (n, 3)."""
    along = np.einsum("ni,ni->n", field, down)
    return np.asarray(np.arctan2(along, np.linalg.norm(field - along[:, None] * down, axis=1)))


def upright(direction: Array, down: Array) -> Array:
    """Unit vectors (n, 3) of increasing dip: across directions (n, 3), in the vertical plane, towards down."""
    across = down - np.einsum("ni,ni->n", direction, down)[:, None] * direction
    return np.asarray(across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), LEAST_LEVEL))


def _weight(off: Array, block: int, policy: Policy) -> Array:
    """Weights (n,) of deviations (n,): 0 for outliers unless they are too many, else 1 over the power and its colour.

    The colour is the largest excess of block means over white noise.
    """
    size = np.abs(off)
    far = size > policy.never_sigma * max(float(np.median(size)), 1e-9)
    near = np.ones(len(off)) - far * float(far.mean() < policy.fair_share)
    residual, excess = off[near > 0], 1.0
    power = max(float((residual**2).mean()), LEAST_NOISE**2)
    for length in (several * block for several in policy.colour_blocks):
        means = residual[: len(residual) // length * length].reshape(-1, length).mean(axis=1)
        if len(means) >= policy.least_colour_means:
            excess = max(excess, float((means**2).mean()) * length / power)
    return np.asarray(near / (power * excess))
