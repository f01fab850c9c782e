"""Damped Gauss-Newton: the least sum of squares from a start, for any kind of point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from scenarios.arrays import Array

Point = TypeVar("Point")
FIRST_DAMPING, LESS, MORE, NO_DAMPING = 1e-3, 0.1, 10.0, 1e-10
"""Of the scaled normal matrix: the damping at first, its factor after a step that gains and after one that does not,
and the damping below which it is left out."""
MOST_DAMPING = 1e4
"""Where no step so short gains, rounding lets the point be no better."""
ROUNDING_COST = 1e-13
"""Share of the cost that its sum rounds away."""
SMALLEST = 1e-14
"""Smallest eigenvalue of the scaled normal matrix that is not rounding."""


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """At a point: sum of squares r^T r, slope J^T r (k,), square J^T J (k, k), and the variance of a residual."""

    cost: float
    slope: Array
    square: Array
    variance: float

    @property
    def scale(self) -> Array:
        """Length (k,) of the columns of J; 1 for a parameter without effect."""
        size = np.sqrt(np.diag(self.square))
        return np.asarray(np.where(size > 0, size, 1.0))


class Problem(Protocol[Point]):
    """What is minimised."""

    def normal(self, point: Point) -> NormalEquations:
        """Cost and normal equations at a point."""

    def moved(self, point: Point, step: Array) -> Point | None:
        """The point a step (k,) further; None where there is none."""


@dataclass(frozen=True, eq=False)
class Minimum(Generic[Point]):
    """Where the steps end; history: the length of each undamped step, in standard deviations."""

    point: Point
    normal: NormalEquations
    history: tuple[float, ...]
    settled: bool


def minimised(problem: Problem[Point], start: Point, most_steps: int, tolerance: float) -> Minimum[Point]:
    """From a start until an undamped step is shorter than `tolerance` standard deviations, or no step gains.

    (J^T J + damping diag J^T J) step = -J^T r    [Levenberg1944] [Marquardt1963]

    Where a step does not gain, the next from its end is taken before it is given up: along a curved valley the first
    climbs the wall and the second falls back to the floor.
    """
    point, damping = At.of(problem, start), FIRST_DAMPING
    history: list[float] = []
    for _ in range(most_steps):
        history.append(point.decrement)
        if history[-1] < tolerance:
            return Minimum(point.point, point.normal, tuple(history), True)
        further = _gained(problem, point, damping)
        while further is None and damping < MOST_DAMPING:
            damping = max(damping, NO_DAMPING) * MORE
            further = _gained(problem, point, damping)
        if further is None:
            break
        point, damping = further, (damping * LESS if damping > NO_DAMPING else 0.0)
    return Minimum(point.point, point.normal, tuple(history), False)


@dataclass(frozen=True, eq=False)
class At(Generic[Point]):
    """A point with its normal equations along their own axes, each parameter in units of its column.

    values (k,), axes (k, k) : of the scaled square; slope (k,) : along the axes
    """

    point: Point
    normal: NormalEquations
    values: Array
    axes: Array
    slope: Array

    @classmethod
    def of(cls, problem: Problem[Point], point: Point) -> At[Point]:
        """The point with the normal equations of the problem."""
        normal = problem.normal(point)
        values, axes = np.linalg.eigh(normal.square / np.outer(normal.scale, normal.scale))
        return cls(point, normal, np.maximum(values, SMALLEST), axes, axes.T @ (normal.slope / normal.scale))

    @property
    def decrement(self) -> float:
        """Length of the undamped step, in standard deviations."""
        return float(np.sqrt(np.sum(self.slope**2 / self.values) / self.normal.variance))

    def stepped(self, problem: Problem[Point], damping: float) -> At[Point] | None:
        """The point behind the damped step; None where the problem does not allow the step."""
        step = -self.axes @ (self.slope / (self.values + damping)) / self.normal.scale
        further = problem.moved(self.point, step)
        return None if further is None else At.of(problem, further)

    def no_worse(self, other: At[Point] | None) -> At[Point] | None:
        """The other point if the cost is not higher, else None."""
        gains = other is not None and other.normal.cost <= self.normal.cost * (1.0 + ROUNDING_COST)
        return other if gains else None


def _gained(problem: Problem[Point], point: At[Point], damping: float) -> At[Point] | None:
    """The point behind a damped step, or two, with lower cost; None without a gain."""
    once = point.stepped(problem, damping)
    if once is None or point.no_worse(once) is not None:
        return once
    return point.no_worse(once.stepped(problem, damping))
