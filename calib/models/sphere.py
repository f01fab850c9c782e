"""Fit of a sphere to noisy points, and the bias of the centre by soft iron outside the model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from calib.models.quadric import design, shape_matrix
from scenarios.arrays import Array

BLOCK = 16_384
"""Points whose rows are factored together; the factor R of the blocks before is put above them."""


@dataclass(frozen=True, eq=False)
class SphereFit:
    """The linear fit of (centre, radius^2 - |centre|^2) to |x|^2: its rows' factor R (4, 4), solution, misfit^2."""

    x: Array
    r: Array
    solution: Array
    misfit_square: float

    @classmethod
    def of(cls, x: Array) -> SphereFit:
        """To points (n, 3)."""
        r = _factor(x, soft=False)
        solution = np.asarray(np.linalg.solve(r[:4, :4], r[:4, 4]), np.float64)
        return cls(x, r[:4, :4], solution, float(r[4, 4] ** 2))

    @property
    def centre(self) -> Array:
        """Centre (3,)."""
        return self.solution[:3]

    @property
    def radius(self) -> float:
        """Radius."""
        return float(np.sqrt(self.solution[3] + self.centre @ self.centre))

    @property
    def noise_std(self) -> float:
        """Noise of a component of x."""
        return float(np.sqrt(self.misfit_square / (len(self.x) - 4))) / (2 * self.radius)

    def mean_square_error(self) -> tuple[Array, float, float]:
        """Mean square error (4, 4) of the solution, the length of the centre's bias by the soft iron left out, and the
        standard deviation of the centre, in its worst direction, by what noise leaves unknown of that soft iron.

        sigma^2 R^-1 R^-T + k beta beta^T,  beta = theta - (A^-1 c', d'),  (c', d') = theta - R^-1 Q^T Z gamma,
        A = I - Gamma,  k = max(0, 1 - 5 sigma^2 / |Z' gamma|^2): what noise alone would explain is no bias
        cov(gamma) = sigma^2 (Z'^T Z')^-1,  d(A^-1 c') / d gamma_i = A^-1 (Gamma_i A^-1 c' - (R^-1 Q^T Z)_i)
        """
        r = _factor(self.x, soft=True)
        inverse = np.linalg.inv(r[:4, :4])
        alias = inverse @ r[:4, 4:9]
        gamma, variance, share = _soft_iron(r[4:9, 4:9], r[4:, 9], len(self.x))
        full = self.solution - alias @ gamma
        shape = np.eye(3) - _soft_matrix(gamma)
        full[:3] = np.linalg.solve(shape, full[:3])
        bias = np.sqrt(share) * (self.solution - full)
        turned = np.column_stack([_soft_matrix(unit) @ full[:3] for unit in np.eye(5)])
        slope = np.linalg.solve(shape, turned - alias[:3])
        unknown = np.sqrt(variance) * np.linalg.norm(slope @ np.linalg.pinv(r[4:9, 4:9]), 2)
        return variance * inverse @ inverse.T + np.outer(bias, bias), float(np.linalg.norm(bias[:3])), float(unknown)


def _factor(x: Array, *, soft: bool) -> Array:
    """R (k, k) of the columns 2 x, 1, with `soft` Z (n, 5), and |x|^2 of points (n, 3), block by block."""
    r = np.zeros((10 if soft else 5,) * 2)
    for first in range(0, len(x), BLOCK):
        part = x[first : first + BLOCK]
        terms = (_soft_iron_terms(part),) if soft else ()
        rows = np.column_stack((2 * part, np.ones(len(part)), *terms, (part * part).sum(axis=1)))
        r = np.asarray(np.linalg.qr(np.concatenate((r, rows)), mode="r"), np.float64)
    return r


def _soft_iron_terms(x: Array) -> Array:
    """Z (n, 5): the trace-free quadratic terms of points (n, 3)."""
    quadratic = design(x)[:, :6]
    return np.column_stack((quadratic[:, 0] - quadratic[:, 2], quadratic[:, 1] - quadratic[:, 2], quadratic[:, 3:]))


def _soft_matrix(gamma: Array) -> Array:
    """Gamma (3, 3), trace-free, of its five terms."""
    return shape_matrix(np.array([gamma[0], gamma[1], -gamma[0] - gamma[1], *gamma[2:]]))


def _soft_iron(root: Array, rest: Array, count: int) -> tuple[Array, float, float]:
    """gamma (5,), the noise's variance without it, and its share k.

    root (5, 5) : factor of Z', which is Z clear of the fitted columns; rest (6,) : of |x|^2, likewise clear
    """
    gamma = np.linalg.lstsq(root, rest[:5], rcond=np.finfo(float).eps * count)[0]
    explained = float(gamma @ (root.T @ rest[:5]))
    variance = max(float(rest @ rest) - explained, 0.0) / (count - 9)
    share = max(0.0, 1.0 - 5.0 * variance / explained) if explained > 0 else 0.0
    return np.asarray(gamma, dtype=np.float64), variance, share
