"""Calibration by a search over a population: the particle, its bounds, its cost, the polish and the covariance.

A particle is x = (R_xx, R_xy, R_xz, R_yy, R_yz, R_zz, u_x, u_y, u_z), dimensionless, with R upper triangular and
b = middle + F u: the measurements enter as z = (m - middle) / F, so that all nine entries are of order one and
F drops out of the cost. [Zhang2018] eq. 10 to 12.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar, final

import numpy as np
from pydantic import Field

from calib.base import Calibrator
from calib.models.ellipsoid import (
    EllipsoidFit,
    Standardised,
    mean_square_error,
    norm_coordinates,
    symmetric_root,
)
from calib.models.norm import norm_rows
from calib.numerics.kernels import fast_kernel
from calib.observability import Extent, unobservable
from calib.reference import Reference
from calib.result import Calibration, Status
from calib.search.population import Move, SearchResult, search
from calib.settings import Count
from recordings import Recording
from scenarios.arrays import Array
from scenarios.text import figure

ROUNDING_VARIANCE = 1e-18
"""Smallest variance of a residual of unit size: rounding, 1e-9 of the field."""
FIRST_DAMPING, LESS, MORE, MOST_STEPS = 1e-3, 0.2, 8.0, 500
"""Levenberg-Marquardt: the damping at first, its factor after a step that gains and after one that does not."""
ROUNDING_COST = 1e-13
"""Share of f that its sum rounds away."""
STILL = 1e-14
"""A step of this share of the particle is none."""
SMALLEST_SCALE = 1e-12
"""Of a parameter that the measurements do not depend on, beside a direction's one."""
SETTLED = 0.1
"""A search has settled when a Gauss-Newton step from its end is shorter than this many standard deviations."""
TRIANGLE = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
TRIANGULAR_NAMES = ("R_xx", "R_xy", "R_xz", "R_yy", "R_yz", "R_zz")


@fast_kernel
def costs(particles: Array, points: Array) -> Array:
    """f = sum_i (|R (z_i - u)| - 1)^2 of each particle: particles (k, 9), points (3, n), gives (k,)."""
    out = np.empty(len(particles))
    for k in range(len(particles)):
        a, b, c, d, e, f, u, v, w = particles[k]
        tx, ty, tz = a * u + b * v + c * w, d * v + e * w, f * w
        total = 0.0
        for i in range(points.shape[1]):
            x = a * points[0, i] + b * points[1, i] + c * points[2, i] - tx
            y = d * points[1, i] + e * points[2, i] - ty
            z = f * points[2, i] - tz
            r = np.sqrt(x * x + y * y + z * z) - 1.0
            total += r * r
        out[k] = total
    return out


@fast_kernel
def normal_equations(particle: Array, points: Array) -> tuple[Array, Array]:
    """J^T r (9,) and J^T J (9, 9) of the residuals r = |R (z - u)| - 1 and J = dr / d particle, points (3, n).

    With d = z - u and e = R d / |R d| a row of J is e_i d_j for R_ij, and -R^T e for u.
    """
    a, b, c, d, e, f, u, v, w = particle
    row, slope, square = np.empty(9), np.zeros(9), np.zeros((9, 9))
    for i in range(points.shape[1]):
        p, q, s = points[0, i] - u, points[1, i] - v, points[2, i] - w
        x, y, z = a * p + b * q + c * s, d * q + e * s, f * s
        size = np.sqrt(x * x + y * y + z * z)
        x, y, z = x / size, y / size, z / size
        row[0], row[1], row[2], row[3], row[4], row[5] = x * p, x * q, x * s, y * q, y * s, z * s
        row[6], row[7], row[8] = -a * x, -b * x - d * y, -c * x - e * y - f * z
        for j in range(9):
            slope[j] += row[j] * (size - 1.0)
            for k in range(j, 9):
                square[j, k] += row[j] * row[k]
    for j in range(9):
        for k in range(j):
            square[j, k] = square[k, j]
    return slope, square


@dataclass(frozen=True, eq=False)
class NormSpace:
    """The search space: points z (3, n), their middle (3,) and F, nT; bounds lower and upper (9,) of a particle."""

    points: Array
    middle_nT: Array
    strength_nT: float
    lower: Array
    upper: Array

    @classmethod
    def of(cls, mag_nT: Array, strength_nT: float, most_gain: float) -> NormSpace | None:
        """The space of measurements (n, 3), with bounds that the data give; None when no particle can be in them.

        The singular values of S and of R = (S up to a rotation)^-1 lie within 1 / g and g, so 1 / g <= R_ii <= g,
        |R_ij| <= g - 1 / g, and since |m_i - b| <= g F for every sample, max m_i - g F <= b <= min m_i + g F on each
        axis. R_ii >= 1 / g keeps the matrix from shrinking to zero while the offset runs away.
        """
        low, high = mag_nT.min(axis=0), mag_nT.max(axis=0)
        middle = (low + high) / 2
        reach = most_gain - (high - low) / (2 * strength_nT)
        if reach.min() <= 0:
            return None
        least, off = 1.0 / most_gain, most_gain - 1.0 / most_gain
        lower = np.array([least, -off, -off, least, -off, least, *-reach])
        upper = np.array([most_gain, off, off, most_gain, off, most_gain, *reach])
        return cls(np.ascontiguousarray(((mag_nT - middle) / strength_nT).T), middle, strength_nT, lower, upper)

    def costs(self, particles: Array) -> Array:
        """f (k,) of particles (k, 9): [Zhang2018] eq. 22 in units of F^2."""
        return costs(particles, self.points)

    @property
    def standardised(self) -> Standardised:
        """The points in units of F about their middle."""
        return Standardised(self.points.T, self.middle_nT, self.strength_nT)

    def rmse_nT(self, cost: Array | float) -> Array:
        """Root mean square of |h| - F, nT, from f: the measure of [Zhang2018] fig. 10."""
        return np.asarray(self.strength_nT * np.sqrt(np.asarray(cost) / self.points.shape[1]))

    def residuals(self, particle: Array) -> Array:
        """|R (z - u)| - 1 (n,)."""
        return np.asarray(np.linalg.norm(triangular(particle) @ (self.points - particle[6:, None]), axis=0) - 1.0)

    def jacobian(self, particle: Array) -> Array:
        """d residual / d particle (n, 9): e_i d_j for R_ij and -R^T e for u, with d = z - u, e = R d / |R d|."""
        R, d = triangular(particle), self.points - particle[6:, None]
        e = R @ d
        e /= np.linalg.norm(e, axis=0)
        return np.concatenate(([e[i] * d[j] for i, j in TRIANGLE], -(R.T @ e))).T

    def polished(self, particle: Array) -> Array:
        """The minimum of f next to a particle: Levenberg-Marquardt, until a step no longer changes it.

        (J^T J + damping diag J^T J) step = -J^T r
        """
        best, damping = particle, FIRST_DAMPING
        cost = self._cost(best)
        slope, square = normal_equations(best, self.points)
        for _ in range(MOST_STEPS):
            scale = np.maximum(np.diag(square), SMALLEST_SCALE)
            step = np.linalg.solve(square + damping * np.diag(scale), -slope)
            if np.linalg.norm(step) <= STILL * np.linalg.norm(best):
                break
            trial = self._cost(best + step)
            gains = trial <= cost * (1.0 + ROUNDING_COST)
            damping *= LESS if gains else MORE
            if gains:
                best, cost = best + step, trial
                slope, square = normal_equations(best, self.points)
        return best

    def _cost(self, particle: Array) -> float:
        return float(self.costs(particle[None, :])[0])

    def inside(self, particle: Array) -> bool:
        """Whether a particle keeps to the bounds."""
        return bool(((particle >= self.lower) & (particle <= self.upper)).all())


@dataclass(frozen=True)
class PopulationCalibrator(Calibrator):
    """Offset and symmetric S from |h| = F by a search over a population of particles; a subclass writes `move`.

    |R (m - b)| = F,  f(R, b) = sum_i (|R (m_i - b)| - F)^2       [Zhang2018] eq. 12, 22 (F for the printed H^b)

    R upper triangular: the norm says nothing of the rotation Q in S^-1 = Q R. `matrix` is the symmetric one of them,
    (R^T R)^(1/2), which does not depend on the choice of axes. `population`, `iterations`: the paper's. `most_gain`:
    largest singular value of S and of its inverse that the bounds admit, see `Problem.of`.

    `polish`: finish with Levenberg-Marquardt on the same f. On by default, because with the paper's settings the
    searches end many standard deviations from the minimum of their own cost; off, it is the paper's method, and the
    status says how far from the minimum it ended. Covariance: linearised at the solution, noise from the residual.
    """

    min_samples: ClassVar[int] = 10
    population: Annotated[int, Field(ge=2)] = 100
    iterations: Count = 200
    most_gain: Annotated[float, Field(gt=1)] = 1.5
    polish: bool = True

    @abstractmethod
    def move(self, space: NormSpace) -> Move:
        """The method itself: what a generation does."""

    @final
    def search(self, space: NormSpace, rng: np.random.Generator) -> SearchResult:
        """The search alone, without the polish."""
        return search(space, self.move(space), self.population, self.iterations, rng)

    @final
    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        space = NormSpace.of(recording.mag_nT, reference.strength_nT, self.most_gain)
        if space is None:
            return Status("not_converged", self._gain_text(recording.mag_nT))
        found = self.search(space, rng)
        best = space.polished(found.best) if self.polish else found.best
        history = tuple(space.rmse_nT(found.costs).tolist())
        if not space.inside(best):
            return Calibration(name=self.name, status=self._lost(space), history=history)
        noise = _noise_std(space, best)
        fit = space.standardised.calibration(
            self.name, _settled(space, best, noise), ellipsoid_fit(space, best, noise, history), reference
        )
        triangle = dict(zip(TRIANGULAR_NAMES, best[:6].tolist(), strict=True))
        return replace(fit, parameters=fit.parameters | triangle | {"search_rmse_nT": history[-1]})

    def _lost(self, space: NormSpace) -> Status:
        """Unobservable: the minimum lies out of the bounds."""
        return unobservable(
            Extent.of(space.points.T).thinnest,
            "the strength is fitted best out of the bounds that the data give, where the offset runs away as the "
            f"matrix shrinks (or a gain is beyond most_gain = {self.most_gain:g})",
        )

    def _gain_text(self, mag_nT: Array) -> str:
        return (
            f"the measurements range over {figure(np.ptp(mag_nT, axis=0).max(), 4)} nT on one axis, more than a "
            "gain of "
            f"{self.most_gain:g} allows: check the field strength and the unit, or raise most_gain"
        )


def triangular(particle: Array) -> Array:
    """R (3, 3) of a particle (9,)."""
    R = np.zeros((3, 3))
    R[np.triu_indices(3)] = particle[:6]
    return R


def _noise_std(space: NormSpace, particle: Array) -> float:
    residual = space.residuals(particle)
    variance = float(residual @ residual) / (len(residual) - 9)
    return float(np.sqrt(max(variance, ROUNDING_VARIANCE)))


def ellipsoid_fit(space: NormSpace, particle: Array, noise: float, history: tuple[float, ...]) -> EllipsoidFit:
    """The ellipsoid of a particle, T = (R^T R)^(1/2), and its covariance for white noise in the radial residual."""
    R = triangular(particle)
    T = symmetric_root(R.T @ R)
    p = norm_coordinates(T, T @ particle[6:])
    _, rows = norm_rows(p, space.points.T)
    error = mean_square_error(_squares(rows.T), noise**2)
    return EllipsoidFit.of_norm(p, error, noise, history)


def _squares(rows: Array) -> Array:
    """rows rows^T of (9, n); by einsum, since a threaded product of so few rows costs more than it saves."""
    return np.asarray(np.einsum("in,jn->ij", rows, rows))


def _settled(space: NormSpace, particle: Array, noise: float) -> Status:
    """Not converged when a Gauss-Newton step is longer than SETTLED standard deviations: |J step| / noise."""
    jacobian = space.jacobian(particle)
    slope = np.einsum("ni,n->i", jacobian, space.residuals(particle))
    decrement = float(np.sqrt(slope @ np.linalg.solve(_squares(jacobian.T), slope))) / noise
    if decrement <= SETTLED:
        return Status("ok")
    return Status(
        "not_converged",
        f"the search ended {figure(decrement, 2)} standard deviations from the minimum of its own "
        "cost: use polish = true, or more iterations",
    )
