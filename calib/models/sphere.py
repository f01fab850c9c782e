"""Fit of a sphere to noisy points, and the bias of the centre by soft iron outside the model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from calib.models.quadric import design, shape_matrix
from scenarios.arrays import Array


@dataclass(frozen=True, eq=False)
class SphereFit:
    """The linear fit of (centre, radius^2 - |centre|^2) to |x|^2: its rows' factors q, r, solution and misfit."""

    x: Array
    q: Array
    r: Array
    solution: Array
    misfit: Array

    @classmethod
    def of(cls, x: Array) -> SphereFit:
        """To points (n, 3)."""
        rows = np.concatenate((2 * x, np.ones((len(x), 1))), axis=1)
        q, r = np.linalg.qr(rows)
        squared = (x * x).sum(axis=1)
        solution = np.linalg.solve(r, q.T @ squared)
        return cls(x, q, r, solution, squared - rows @ solution)

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
        return float(np.sqrt(self.misfit @ self.misfit / (len(self.x) - 4))) / (2 * self.radius)

    def mean_square_error(self) -> tuple[Array, float, float]:
        """Mean square error (4, 4) of the solution, the length of the centre's bias by the soft iron left out, and the
        standard deviation of the centre, in its worst direction, by what noise leaves unknown of that soft iron.

        sigma^2 R^-1 R^-T + k beta beta^T,  beta = theta - (A^-1 c', d'),  (c', d') = theta - R^-1 Q^T Z gamma,
        A = I - Gamma,  k = max(0, 1 - 5 sigma^2 / |Z' gamma|^2): what noise alone would explain is no bias
        cov(gamma) = sigma^2 (Z'^T Z')^-1,  d(A^-1 c') / d gamma_i = A^-1 (Gamma_i A^-1 c' - (R^-1 Q^T Z)_i)
        """
        softness = _soft_iron_terms(self.x)
        alias = self.q.T @ softness
        clear = softness - self.q @ alias
        gamma, variance, share = _soft_iron(clear, self.misfit)
        inverse = np.linalg.inv(self.r)
        full = self.solution - inverse @ alias @ gamma
        shape = np.eye(3) - _soft_matrix(gamma)
        full[:3] = np.linalg.solve(shape, full[:3])
        bias = np.sqrt(share) * (self.solution - full)
        turned = np.column_stack([_soft_matrix(unit) @ full[:3] for unit in np.eye(5)])
        slope = np.linalg.solve(shape, turned - (inverse @ alias)[:3])
        unknown = np.sqrt(variance) * np.linalg.norm(slope @ np.linalg.pinv(clear), 2)
        return variance * inverse @ inverse.T + np.outer(bias, bias), float(np.linalg.norm(bias[:3])), float(unknown)


def _soft_iron_terms(x: Array) -> Array:
    """Z (n, 5): the trace-free quadratic terms of points (n, 3)."""
    quadratic = design(x)[:, :6]
    return np.column_stack((quadratic[:, 0] - quadratic[:, 2], quadratic[:, 1] - quadratic[:, 2], quadratic[:, 3:]))


def _soft_matrix(gamma: Array) -> Array:
    """Gamma (3, 3), trace-free, of its five terms."""
    return shape_matrix(np.array([gamma[0], gamma[1], -gamma[0] - gamma[1], *gamma[2:]]))


def _soft_iron(clear: Array, misfit: Array) -> tuple[Array, float, float]:
    """gamma (5,), the noise's variance without it, and its share k, from Z' clear of the fitted columns."""
    gamma = np.linalg.lstsq(clear, misfit, rcond=None)[0]
    explained = float(gamma @ (clear.T @ misfit))
    variance = max(float(misfit @ misfit) - explained, 0.0) / (len(misfit) - 9)
    share = max(0.0, 1.0 - 5.0 * variance / explained) if explained > 0 else 0.0
    return np.asarray(gamma, dtype=np.float64), variance, share
