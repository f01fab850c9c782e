"""A turn about the vertical: five direction cosines of the sensor's axes, their cost, and how sure they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import fdtri

from calib.numerics.colour import inflation
from calib.numerics.kernels import fast_kernel
from scenarios.arrays import Array

NAMES = ("a1", "b1", "b2", "c1", "c2")
PLACES = ((0, 2), (1, 0), (1, 2), (2, 0), (2, 1))
"""Where in A each of the five stands."""
ROUNDING = 1e-7
"""Residual that rounding alone gives, as a fraction of the field."""
PER_VERTICAL, PER_LENGTH = 3, 3
"""Parameters that each residual alone determines: c1, c2 and the mean of z; a1 + c1, b2 + c2 and b1."""
LEANING, LEVEL_CHANCE = 2.0, 1e-4
"""Not level: z scatters by this factor more than the length, as axes of unequal noise do not, and by more than level
stops do with this chance, which for twelve stops is a factor of 5.6."""
SCATTER_CHANCE = 0.05
"""The share of level recordings whose claim has a lean in it."""


def axes_matrix(theta: Array) -> Array:
    """A (3, 3) with rows (., 0, a1), (b1, ., b2), (c1, c2, .) of length one ([Zhou2012])."""
    a1, b1, b2, c1, c2 = theta
    return np.array(
        [[np.sqrt(1 - a1**2), 0.0, a1], [b1, np.sqrt(1 - b1**2 - b2**2), b2], [c1, c2, np.sqrt(1 - c1**2 - c2**2)]]
    )


@fast_kernel
def costs(particles: Array, points: Array, total: float) -> Array:
    """Sum of squared deviations of z and of the length of A^-1 m: particles (k, 5), points (3, n), gives (k,).

    z from its mean; the length from `total`, or from its mean where total <= 0.
    """
    n = points.shape[1]
    out, vertical, length = np.empty(len(particles)), np.empty(n), np.empty(n)
    for k in range(len(particles)):
        a1, b1, b2, c1, c2 = particles[k]
        a0, b0, c0 = np.sqrt(1 - a1 * a1), np.sqrt(1 - b1 * b1 - b2 * b2), np.sqrt(1 - c1 * c1 - c2 * c2)
        determinant = a0 * (b0 * c0 - b2 * c2) + a1 * (b1 * c2 - b0 * c1)
        for i in range(n):
            x, y, z = points[0, i], points[1, i], points[2, i]
            hx = ((b0 * c0 - b2 * c2) * x + a1 * c2 * y - a1 * b0 * z) / determinant
            hy = ((b2 * c1 - b1 * c0) * x + (a0 * c0 - a1 * c1) * y + (a1 * b1 - a0 * b2) * z) / determinant
            hz = ((b1 * c2 - b0 * c1) * x - a0 * c2 * y + a0 * b0 * z) / determinant
            vertical[i] = hz
            length[i] = np.sqrt(hx * hx + hy * hy + hz * hz)
        middle = vertical.mean()
        aim = total if total > 0.0 else length.mean()
        out[k] = ((vertical - middle) ** 2).sum() + ((length - aim) ** 2).sum()
    return out


def derivatives(theta: Array) -> list[Array]:
    """dA / d theta_k, five of (3, 3): the entry, and the diagonal that keeps the row at unit length."""
    A, out = axes_matrix(theta), []
    for (i, j), value in zip(PLACES, theta, strict=True):
        step = np.zeros((3, 3))
        step[i, j], step[i, i] = 1.0, -value / A[i, i]
        out.append(step)
    return out


@dataclass(frozen=True, eq=False)
class TurnSpace:
    """The five within +-`bound`, on points (3, n) m / F; `total` as in `costs`."""

    points: Array
    bound: float
    total: float

    @property
    def lower(self) -> Array:
        """Least values (5,)."""
        return np.full(len(NAMES), -self.bound)

    @property
    def upper(self) -> Array:
        """Greatest values (5,)."""
        return np.full(len(NAMES), self.bound)

    def costs(self, individuals: Array) -> Array:
        """Costs (k,) of individuals (k, 5)."""
        return np.asarray(costs(individuals, self.points, self.total))


@dataclass(frozen=True, eq=False)
class Residuals:
    """Deviations of z and of the length of h = A^-1 m at a solution, each (n,), with their Jacobians (n, 5).

    dh = -A^-1 dA h;  `share` r = V / F: the correlation between the noise of z and that of the length.
    """

    vertical: Array
    length: Array
    d_vertical: Array
    d_length: Array
    share: float
    free: int

    @classmethod
    def of(cls, points: Array, theta: Array, known_total: bool) -> Residuals:
        """At theta (5,) on points m / F (3, n), from a known length of one or from the mean length."""
        inverse = np.linalg.inv(axes_matrix(theta))
        h = inverse @ points
        length = np.linalg.norm(h, axis=0)
        steps = np.array([-inverse @ step @ h for step in derivatives(theta)])
        d_length = ((steps * h).sum(axis=1) / length).T
        d_vertical = steps[:, 2].T
        return cls(
            h[2] - h[2].mean(),
            length - (1.0 if known_total else float(length.mean())),
            d_vertical - d_vertical.mean(axis=0),
            d_length if known_total else d_length - d_length.mean(axis=0),
            float(h[2].mean() / length.mean()),
            2 * points.shape[1] - (1 if known_total else 2),
        )

    @property
    def normal(self) -> Array:
        """J^T J (5, 5)."""
        return np.asarray(self.d_vertical.T @ self.d_vertical + self.d_length.T @ self.d_length)

    @property
    def slope(self) -> Array:
        """J^T residual (5,)."""
        return np.asarray(self.d_vertical.T @ self.vertical + self.d_length.T @ self.length)

    @property
    def scatter(self) -> tuple[float, float]:
        """Standard deviations of the noise of z, lean of the stops included, and of the length, in parts of F."""
        n = len(self.vertical)
        of_z = float(self.vertical @ self.vertical) / (n - PER_VERTICAL)
        of_length = float(self.length @ self.length) / (self.free - n - PER_LENGTH + 1)
        return float(np.sqrt(of_z)), float(np.sqrt(max(of_length, ROUNDING**2)))

    def excess(self, chance: float) -> float:
        """Variance of z beyond that of the length, in parts of F^2; 0 for less than level stops have with a chance.

        F test of the two variances: a lean of the level stops turns the field in z and keeps its length.
        """
        of_z, of_length = self.scatter
        rows = len(self.vertical) / inflation(self.length)
        limit = float(fdtri(max(rows - PER_VERTICAL, 1.0), max(rows - PER_LENGTH - 1, 1.0), 1.0 - chance))
        return of_z**2 - of_length**2 if of_z**2 > limit * of_length**2 else 0.0

    @property
    def lean(self) -> float:
        """Rms lean of the stops towards the horizontal field, radians; 0 where z tells of none."""
        of_z, of_length = self.scatter
        seen = self.excess(LEVEL_CHANCE) if of_z > LEANING * of_length else 0.0
        return float(np.sqrt(seen / max(1.0 - self.share**2, ROUNDING)))

    def covariance(self) -> tuple[Array, float]:
        """Covariance (5, 5), and the noise.

        Residuals correlated by C = [[1, r], [r, 1]] in each sample:  cov = (J^T J)^-1 J^T C J (J^T J)^-1 noise^2,
        E |residual|^2 = noise^2 (tr C - tr (J^T J)^-1 J^T C J). What z scatters beyond the length adds to C_zz alone.
        """
        normal, cross = self.normal, self.share * self.d_vertical.T @ self.d_length
        spread = np.linalg.solve(normal, normal + cross + cross.T)
        square = float(self.vertical @ self.vertical + self.length @ self.length)
        noise = float(np.sqrt(max(square / (self.free - float(np.trace(spread))), ROUNDING**2)))
        leaning = self.excess(SCATTER_CHANCE)
        if leaning:
            noise = self.scatter[1]
        covariance = np.linalg.solve(normal, spread.T) * noise**2
        aside = np.linalg.solve(normal, self.d_vertical.T)
        covariance += leaning * aside @ aside.T
        return np.asarray((covariance + covariance.T) / 2), noise
