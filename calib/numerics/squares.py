"""Nonlinear least squares by a trust region on the normal equations, with a single Jacobian in memory."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import OptimizeResult, minimize

from scenarios.arrays import Array

SAME, SMALLEST_STEP = 1e-6, 1e-5
"""Relative difference of sums of squares that is of no account, and step of the numbers that ends the search."""
DIFFERENCE = 1e-6
"""Step of a number, over its scale, by which a slope is taken; it is off by more than a slope's seventh digit."""
FLOOR = 1e-12
"""What is added to the matrix that is searched with, over its diagonal, or the largest of it where that is zero, or
one where nothing has an effect: all numbers are at their bounds."""
ROWS = 20_000
"""Rows of a Jacobian that are multiplied at a time."""
FORETOLD = 0.5
"""Part of a step's change that a Jacobian may miss and still be corrected, in place of being taken anew."""


@dataclass
class Squares:
    """Half the sum of squares of ``residual(x)`` (n,), its gradient and its Gauss-Newton matrix, of numbers x (k,).

    Those of the last x are kept. A decomposition of the Jacobian (n, k) would hold it three times more: 2 GB for ten
    hours and 40 numbers. During a search a Jacobian that foretold a step is corrected along the step, as Broyden does:
    taken anew it costs a residual for every number. The matrix where a search ended is that of true slopes.
    """

    residual: Callable[[Array], Array]
    _left: tuple[Array, Array] | None = None
    _slope: tuple[Array, Array, Array] | None = None
    _jacobian: tuple[Array, Array, Array] | None = None

    def half(self, x: Array) -> float:
        """Half the sum of squares."""
        left = self._left_at(x)
        return float(left @ left) / 2

    def gradient(self, x: Array) -> Array:
        """``J^T r`` (k,)."""
        return self._slopes(x)[1]

    def gram(self, x: Array) -> Array:
        """``J^T J`` (k, k)."""
        return self._slopes(x)[2]

    def least(self, start: Array, rounds: int) -> Array:
        """Numbers (k,) of least half sum of squares near a start, after at most `rounds` rounds.

        A number without an effect, as at a bound, stays: scipy's search fails on a singular matrix.
        """
        if not self.gradient(start).any():
            return start
        first, used = self._searched(start, rounds)
        self._slope, self._jacobian = None, None  # to an end by slopes that were corrected, on from there by true ones
        best = self._searched(first, rounds - used)[0] if used < rounds else first
        self._slope, self._jacobian = None, None  # a corrected matrix tells no variances
        return best

    def _searched(self, start: Array, rounds: int) -> tuple[Array, int]:
        """Numbers (k,) where a search ends, and its rounds."""
        found = minimize(
            self.half,
            start,
            jac=self.gradient,
            hess=self._regular,
            method="trust-exact",
            callback=_End(start, self.half(start)),
            options={"maxiter": rounds, "gtol": 0.0},
        )
        return np.asarray(found.x), found.nit

    def _regular(self, x: Array) -> Array:
        gram = self.gram(x)
        size = np.diag(gram)
        return np.asarray(gram + FLOOR * np.diag(np.where(size > 0, size, size.max() or 1.0)))

    def _left_at(self, x: Array) -> Array:
        if self._left is None or not np.array_equal(x, self._left[0]):
            self._left = x.copy(), self.residual(x)
        return self._left[1]

    def _slopes(self, x: Array) -> tuple[Array, Array, Array]:
        if self._slope is None or not np.array_equal(x, self._slope[0]):
            left = self._left_at(x)
            J = self._corrected(x, left)
            if J is None:
                self._jacobian, J = None, np.empty((len(x), len(left)), np.float32)
                for i, one in enumerate(np.eye(len(x))):
                    J[i] = (self.residual(x + DIFFERENCE * one) - left) / DIFFERENCE
            products = np.zeros((len(x), len(x) + 1))
            for part in (slice(first, first + ROWS) for first in range(0, len(left), ROWS)):
                rows = J[:, part].astype(np.float64)
                products += rows @ np.vstack([rows, left[part]]).T
            self._slope, self._jacobian = (x.copy(), products[:, -1], products[:, :-1]), (x.copy(), left, J)
        return self._slope

    def _corrected(self, x: Array, left: Array) -> Array | None:
        """The last Jacobian J (k, n), corrected so that ``J s`` is the change over the step s to x; None if far off."""
        if self._jacobian is None:
            return None
        before, last, J = self._jacobian
        step = x - before
        foretold = step.astype(np.float32) @ J
        missed = left - last - foretold
        if np.linalg.norm(missed) > FORETOLD * np.linalg.norm(foretold):
            return None
        for slope, share in zip(J, step / (step @ step), strict=True):
            slope += share * missed
        return J


@dataclass
class _End:
    """Ends a search where a step that was taken changes numbers and squares by nothing of account."""

    x: Array
    half: float

    def __call__(self, intermediate_result: OptimizeResult) -> None:
        x, half = np.array(intermediate_result.x), float(intermediate_result.fun)
        step, gained = np.linalg.norm(x - self.x), self.half - half
        self.x, self.half = x, half
        if 0 < step < SMALLEST_STEP or (step > 0 and gained < SAME * half):
            raise StopIteration
