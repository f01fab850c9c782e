"""Hard and soft iron from the strength of the field: robust, beside a weak prior, however little a motion shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sim.state import Array
from validation.diagnosis.policy import Policy

MOST_STEPS, SETTLED = 60, 1e-9
"""Steps at most, and the relative change of the cost below which they end; also what is nothing beside the field."""
FIRST_DAMPING, DAMPING_FACTOR = 1e-3, 5.0
"""Of the Levenberg-Marquardt steps."""
ROUNDS = 3
"""Times that the colour of what is left, and what lies far off, are found anew."""
PAIRS = (np.array([0, 1, 2, 0, 0, 1]), np.array([0, 1, 2, 1, 2, 2]))
"""Rows and columns of the six elements of a symmetric matrix."""


@dataclass(frozen=True)
class Iron:
    """``h = M (m - o)``: symmetric matrix M (3, 3) and offset o (3,) in nT."""

    matrix: Array
    offset_nT: Array

    def field_nT(self, measured_nT: Array) -> Array:
        """The corrected field (n, 3)."""
        return np.asarray((measured_nT - self.offset_nT) @ self.matrix)


def fitted_iron(measured_nT: Array, strength_nT: Array, block: int, policy: Policy) -> Iron:
    """Iron by which measurements (n, 3) have the field's strength F (n,): ``min sum (|M (m - o)| - F)^2 / v + prior``.

    v is the power of what is left times its colour over means of `block` samples and more, so that a slow disturbance
    bends no axis that the motion hardly shows. What lies far off is left out. No motion is refused: where it shows
    nothing the prior stands, M = 1 and o = 0.
    """
    size, middle_nT = (float(np.median(one)) for one in (np.linalg.norm(measured_nT, axis=1), strength_nT))
    unit = 1.0 if 1 / policy.other_unit < size / middle_nT < policy.other_unit else middle_nT / size
    y, F = measured_nT * (unit / middle_nT), strength_nT / middle_nT
    theta = np.r_[np.eye(3)[PAIRS], np.zeros(3)]
    for _ in range(ROUNDS):
        left = _left(theta, y, F)
        use = _near(np.abs(left), policy)
        theta = _minimum(theta, y, F, use, _power(left[use > 0], block, policy), policy)
    matrix, offset = _parts(theta)
    return Iron(matrix * unit, offset * middle_nT / unit)


def _near(off: Array, policy: Policy) -> Array:
    """1 for samples (n,) that are no failures, all of them where too many would be."""
    far = off > policy.base_outlier * max(float(np.median(off)), SETTLED)
    return np.ones(len(off)) - far * float(far.mean() < policy.most_base_outliers)


def _parts(theta: Array) -> tuple[Array, Array]:
    """Matrix (3, 3) and offset (3,) of the nine numbers."""
    upper = np.zeros((3, 3))
    upper[PAIRS] = theta[:6]
    return upper + upper.T - np.diag(np.diag(upper)), theta[6:]


def _left(theta: Array, y: Array, F: Array) -> Array:
    """``|M (y - o)| - F`` (n,)."""
    matrix, offset = _parts(theta)
    return np.asarray(np.linalg.norm((y - offset) @ matrix, axis=1) - F)


def _slopes(theta: Array, y: Array) -> Array:
    """Derivatives (n, 9) of `_left` by the nine numbers."""
    matrix, offset = _parts(theta)
    from_offset = y - offset
    h = from_offset @ matrix
    u = h / np.maximum(np.linalg.norm(h, axis=1, keepdims=True), SETTLED)
    first, second = PAIRS
    products = u[:, first] * from_offset[:, second] + (u[:, second] * from_offset[:, first]) * (first != second)
    return np.column_stack([products, -u @ matrix])


def _power(left: Array, block: int, policy: Policy) -> float:
    """Power of what is left (n,), times the greatest excess of its block means over those of white noise."""
    power = max(float((left**2).mean()), SETTLED**2)
    excess = 1.0
    for several in policy.colour_blocks:
        length = several * block
        means = left[: len(left) // length * length].reshape(-1, length).mean(axis=1)
        if len(means) >= policy.least_colour_means:
            excess = max(excess, float((means**2).mean()) * length / power)
    return power * excess


def _minimum(theta: Array, y: Array, F: Array, use: Array, power: float, policy: Policy) -> Array:
    """The nine numbers of least cost, by Levenberg-Marquardt steps from a start."""
    prior = np.r_[np.full(6, policy.matrix_prior), np.full(3, policy.offset_prior)]
    middle = np.r_[np.eye(3)[PAIRS], np.zeros(3)]

    def cost(at: Array) -> float:
        return float((use * _left(at, y, F) ** 2).sum() / power + (((at - middle) / prior) ** 2).sum())

    damping, now = FIRST_DAMPING, cost(theta)
    for _ in range(MOST_STEPS):
        J = _slopes(theta, y)
        weighted = J * use[:, None]
        normal = weighted.T @ J / power + np.diag(prior**-2.0)
        downhill = weighted.T @ _left(theta, y, F) / power + (theta - middle) / prior**2
        step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), downhill)
        then = cost(theta - step)
        if then > now:
            damping *= DAMPING_FACTOR
        else:
            settled = now - then < SETTLED * now
            theta, now, damping = theta - step, then, damping / DAMPING_FACTOR
            if settled:
                break
    return theta
