"""Iron as a robust fit beside a weak prior: what ought to vanish, its slopes, and steps to the least cost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from diagnosis.policy import Policy
from scenarios.arrays import Array

MOST_STEPS, SETTLED = 60, 1e-9
"""Steps at most, and the relative change of the cost below which they end; also what is nothing beside the field."""
FIRST_DAMPING, DAMPING_FACTOR = 1e-3, 5.0
"""Of the Levenberg-Marquardt steps."""
ROUNDS = 3
"""Times that the colour of what is left, and what lies far off, are found anew."""


@dataclass(frozen=True)
class Iron:
    """``h = M (m - o)``: matrix M (3, 3) and offset o (3,) in nT."""

    matrix: Array
    offset_nT: Array

    def field_nT(self, measured_nT: Array) -> Array:
        """The corrected field (n, 3)."""
        return np.asarray((measured_nT - self.offset_nT) @ self.matrix.T)

    @property
    def turn(self) -> Array:
        """From the field to the measurement, ``M^-1`` (3, 3)."""
        return np.asarray(np.linalg.inv(self.matrix), dtype=np.float64)

    def measured_nT(self, field_nT: Array) -> Array:
        """What fields (n, 3) are measured as."""
        return np.asarray(field_nT @ self.turn.T + self.offset_nT)


class IronFitTask(Protocol):
    """Numbers (p,) with a middle and a spread of their prior, by which q values of each sample ought to vanish."""

    @property
    def middle(self) -> Array:
        """Middle (p,) of the prior, and the start."""

    @property
    def prior(self) -> Array:
        """Standard deviation (p,) of the prior."""

    def left(self, theta: Array) -> Array:
        """What ought to vanish (n, q), in strengths of the field."""

    def slopes(self, theta: Array) -> Array:
        """Its derivatives (n, q, p) by the numbers."""


def unit_of(measured_nT: Array, strength_nT: Array, policy: Policy) -> tuple[float, float]:
    """Factor that brings measurements (n, 3) to the unit of strengths (n,), 1 where they have it, and their median."""
    size, middle_nT = (float(np.median(one)) for one in (np.linalg.norm(measured_nT, axis=1), strength_nT))
    return 1.0 if 1 / policy.other_unit < size / middle_nT < policy.other_unit else middle_nT / size, middle_nT


def fitted(task: IronFitTask, block: int, policy: Policy) -> Array:
    """The numbers (p,) of ``min sum_a sum left_a^2 / v_a + prior``.

    v (q,) is the power of what is left times its colour over means of `block` samples and more, so that a slow
    disturbance bends no axis that the motion hardly shows. What lies far off is left out.
    """
    theta = task.middle
    for _ in range(ROUNDS):
        left = task.left(theta)
        use = np.column_stack([_near(np.abs(one), policy) for one in left.T])
        power = [_power(one[near > 0], block, policy) for one, near in zip(left.T, use.T, strict=True)]
        theta = _minimum(theta, task, use / np.array(power))
    return theta


def _near(off: Array, policy: Policy) -> Array:
    """1 for samples (n,) that are no failures, all of them where too many would be."""
    far = off > policy.base_outlier * max(float(np.median(off)), SETTLED)
    return np.ones(len(off)) - far * float(far.mean() < policy.most_base_outliers)


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


def _minimum(theta: Array, task: IronFitTask, weight: Array) -> Array:
    """The numbers of least cost, by Levenberg-Marquardt steps from a start; weight (n, q) of each square."""

    def cost(left: Array, at: Array) -> float:
        return float((weight * left**2).sum() + (((at - task.middle) / task.prior) ** 2).sum())

    left = task.left(theta)
    damping, now = FIRST_DAMPING, cost(left, theta)
    for _ in range(MOST_STEPS):
        J = task.slopes(theta)
        weighted = (J * weight[:, :, None]).reshape(-1, len(theta))
        normal = weighted.T @ J.reshape(-1, len(theta)) + np.diag(task.prior**-2.0)
        downhill = weighted.T @ left.ravel() + (theta - task.middle) / task.prior**2
        step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), downhill)
        moved = task.left(theta - step)
        then = cost(moved, theta - step)
        if then > now:
            damping *= DAMPING_FACTOR
        else:
            settled = now - then < SETTLED * now
            theta, left, now, damping = theta - step, moved, then, damping / DAMPING_FACTOR
            if settled:
                break
    return theta
