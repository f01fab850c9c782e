"""Damped Gauss-Newton: the least sum of squares from a start, for any kind of point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Point = TypeVar("Point")
FIRST_DAMPING, LESS, MORE, NO_DAMPING = 1e-3, 0.1, 10.0, 1e-10
"""Of the scaled normal matrix: the damping at first, its factor after a step that gains and after one that does not,
and the damping below which it is left out."""
MOST_DAMPING = 1e10
"""No step so short gains: the point is where rounding lets it be."""
ROUNDING_COST = 1e-13
"""Share of the cost that its sum rounds away."""
SMALLEST = 1e-14
"""Smallest eigenvalue of the scaled normal matrix that is not rounding."""


@dataclass(frozen=True, eq=False)
class Normal:
    """At a point: sum of squares r^T r, slope J^T r (k,), square J^T J (k, k), and the variance of a residual."""

    cost: float
    slope: Array
    square: Array
    variance: float

    @property
    def scale(self) -> Array:
        """Length (k,) of the columns of J; one for a parameter that nothing depends on."""
        size = np.sqrt(np.diag(self.square))
        return np.asarray(np.where(size > 0, size, 1.0))


class Problem(Protocol[Point]):
    """What is minimised."""

    def normal(self, point: Point) -> Normal:
        """Cost and normal equations at a point."""

    def moved(self, point: Point, step: Array) -> Point | None:
        """The point a step (k,) further; None where there is none."""


@dataclass(frozen=True, eq=False)
class Minimum(Generic[Point]):
    """Where the steps end; history: the length of each undamped step, in standard deviations."""

    point: Point
    normal: Normal
    history: tuple[float, ...]
    settled: bool


def minimised(problem: Problem[Point], start: Point, most_steps: int, tolerance: float) -> Minimum[Point]:
    """From a start until an undamped step is shorter than `tolerance` standard deviations, or no step gains.

    (J^T J + damping diag J^T J) step = -J^T r    [Levenberg1944] [Marquardt1963]
    """
    point, normal, damping = start, problem.normal(start), FIRST_DAMPING
    history: list[float] = []
    for _ in range(most_steps):
        values, axes, slope = _axes(normal)
        history.append(float(np.sqrt(np.sum(slope**2 / np.maximum(values, SMALLEST)) / normal.variance)))
        if history[-1] < tolerance:
            return Minimum(point, normal, tuple(history), True)
        while True:
            step = -axes @ (slope / (np.maximum(values, SMALLEST) + damping)) / normal.scale
            further = problem.moved(point, step)
            found = None if further is None else problem.normal(further)
            if further is not None and found is not None and found.cost <= normal.cost * (1.0 + ROUNDING_COST):
                break
            damping = max(damping, NO_DAMPING) * MORE
            if damping > MOST_DAMPING:
                return Minimum(point, normal, tuple(history), False)
        point, normal = further, found
        damping = damping * LESS if damping > NO_DAMPING else 0.0
    return Minimum(point, normal, tuple(history), False)


def _axes(normal: Normal) -> tuple[Array, Array, Array]:
    """Eigenvalues (k,) and axes (k, k) of the square, each parameter in units of its column, and the slope along."""
    scale = normal.scale
    values, axes = np.linalg.eigh(normal.square / np.outer(scale, scale))
    return values, axes, axes.T @ (normal.slope / scale)
