"""What the population searches share: the particle, its bounds, its cost, the polish and the calibration.

A particle is x = (R_xx, R_xy, R_xz, R_yy, R_yz, R_zz, u_x, u_y, u_z), dimensionless, with R upper triangular and
b = middle + F u: the measurements enter as z = (m - middle) / F, so that all nine entries are of order one and
F drops out of the cost. [Zhang2018] eq. 10 to 12.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np
import scipy.optimize
from numpy.typing import NDArray

from calib.base import Calibrator
from calib.models.norm import SYMMETRIC_NAMES
from calib.numerics.kernels import kernel
from calib.observability import planar_status, thinnest_direction, unobservable
from calib.reference import Reference
from calib.result import OFFSET_NAMES, Calibration, Status
from sim.dataset import Recording

Array = NDArray[np.float64]
ROUNDING_VARIANCE = 1e-18
"""Smallest variance of a residual of unit size: rounding, 1e-9 of the field."""
SETTLED = 0.1
"""A search has settled when a Gauss-Newton step from its end is shorter than this many standard deviations."""
TRIANGLE = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
TRIANGULAR_NAMES = ("R_xx", "R_xy", "R_xz", "R_yy", "R_yz", "R_zz")


@kernel
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


@dataclass(frozen=True, eq=False)
class Problem:
    """The search: points z (3, n), their middle (3,) and F, nT; bounds lower and upper (9,) of a particle."""

    points: Array
    middle_nT: Array
    strength_nT: float
    lower: Array
    upper: Array

    @classmethod
    def of(cls, mag_nT: Array, strength_nT: float, most_gain: float) -> Problem | None:
        """The problem of measurements (n, 3), with bounds that the data give; None when no particle can be in them.

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

    def rmse_nT(self, cost: Array | float) -> Array:
        """Root mean square of |h| - F, nT, from f: the measure of [Zhang2018] fig. 10."""
        return np.asarray(self.strength_nT * np.sqrt(np.asarray(cost) / self.points.shape[1]))

    def start(self, count: int, rng: np.random.Generator) -> Array:
        """Particles (count, 9) spread evenly over the bounds."""
        return np.asarray(self.lower + rng.random((count, 9)) * (self.upper - self.lower))

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
        """The minimum of f next to a particle: Levenberg-Marquardt."""
        found = scipy.optimize.least_squares(
            self.residuals, particle, self.jacobian, method="lm", xtol=1e-14, ftol=1e-14, gtol=1e-14, max_nfev=500
        )
        return np.asarray(found.x)

    def inside(self, particle: Array) -> bool:
        """Whether a particle keeps to the bounds."""
        return bool(((particle >= self.lower) & (particle <= self.upper)).all())


@dataclass(frozen=True, eq=False)
class Search:
    """How a search went: its best particle (9,) and the cost of its best after each iteration."""

    best: Array
    costs: Array


@dataclass(frozen=True)
class PopulationCalibrator(Calibrator):
    """Offset and symmetric S from |h| = F by a search over a population of particles; a subclass writes `search`.

    |R (m - b)| = F,  f(R, b) = sum_i (|R (m_i - b)| - F)^2       [Zhang2018] eq. 12, 22 (F for the printed H^b)

    R upper triangular: the norm says nothing of the rotation Q in S^-1 = Q R. `matrix` is the symmetric one of them,
    (R^T R)^(1/2), which does not depend on the choice of axes. `population`, `iterations`: the paper's. `most_gain`:
    largest singular value of S and of its inverse that the bounds admit, see `Problem.of`.

    `polish`: finish with Levenberg-Marquardt on the same f. On by default, because with the paper's settings the
    searches end many standard deviations from the minimum of their own cost; off, it is the paper's method, and the
    status says how far from the minimum it ended. Covariance: linearised at the solution, noise from the residual.
    """

    min_samples: ClassVar[int] = 20
    population: int = 100
    iterations: int = 200
    most_gain: float = 1.5
    polish: bool = True

    @abstractmethod
    def search(self, problem: Problem, rng: np.random.Generator) -> Search:
        """The method itself."""

    @final
    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        mag_nT = recording.mag_nT
        flat = planar_status(mag_nT, 0.0)
        if flat is not None:
            return flat
        problem = Problem.of(mag_nT, reference.strength_nT, self.most_gain)
        if problem is None:
            return Status("not_converged", self._gain_text(mag_nT))
        found = self.search(problem, rng)
        best = problem.polished(found.best) if self.polish else found.best
        history = tuple(problem.rmse_nT(found.costs).tolist())
        noise = _noise_std(problem, best)
        lost = self._lost(problem, best, noise) or (
            planar_status(mag_nT, noise * reference.strength_nT) if self.polish else None
        )
        if lost is not None:
            return Calibration(name=self.name, status=lost, history=history)
        return _calibration(self.name, problem, best, noise, history)

    def _lost(self, problem: Problem, best: Array, noise: float) -> Status | None:
        """Unobservable when the minimum lies out of the bounds."""
        if problem.inside(best):
            return None
        return unobservable(
            thinnest_direction(problem.points.T),
            (
                "the strength is fitted best out of the bounds that the data give, where the offset runs away as the "
                f"matrix shrinks (or a gain is beyond most_gain = {self.most_gain:g})"
            ),
        )

    def _gain_text(self, mag_nT: Array) -> str:
        return (
            f"the measurements range over {np.ptp(mag_nT, axis=0).max():.4g} nT on one axis, more than a gain of "
            f"{self.most_gain:g} allows: check the field strength and the unit, or raise most_gain"
        )


def triangular(particle: Array) -> Array:
    """R (3, 3) of a particle (9,)."""
    R = np.zeros((3, 3))
    R[np.triu_indices(3)] = particle[:6]
    return R


def _noise_std(problem: Problem, particle: Array) -> float:
    residual = problem.residuals(particle)
    variance = float(residual @ residual) / (len(residual) - 9)
    return float(np.sqrt(max(variance, ROUNDING_VARIANCE)))


def _calibration(name: str, problem: Problem, particle: Array, noise: float, history: tuple[float, ...]) -> Calibration:
    R = triangular(particle)
    squares, axes = np.linalg.eigh(R.T @ R)
    matrix = (axes * np.sqrt(squares)) @ axes.T
    soft = (axes / np.sqrt(squares)) @ axes.T
    offset_nT = problem.middle_nT + problem.strength_nT * particle[6:]
    inverse = np.linalg.inv(_information(problem, particle[6:], matrix))
    units = np.array([problem.strength_nT] * 3 + [1.0] * 6)
    names = (*OFFSET_NAMES, *SYMMETRIC_NAMES)
    values = np.concatenate((offset_nT, soft[np.triu_indices(3)], particle[:6]))
    parameters = dict(zip((*names, *TRIANGULAR_NAMES), values.tolist(), strict=True)) | {
        "noise_std_nT": noise * problem.strength_nT,
        "search_rmse_nT": history[-1],
    }
    covariance = noise**2 * (inverse + inverse.T) / 2 * np.outer(units, units)
    return Calibration(
        name=name,
        status=_settled(problem, particle, noise),
        offset_nT=offset_nT,
        matrix=matrix,
        parameters=parameters,
        covariance=covariance,
        covariance_names=names,
        history=history,
    )


def _information(problem: Problem, u: Array, matrix: Array) -> Array:
    """J^T J (9, 9) with J = d (|S^-1 (z - u)| - 1) / d (u, S_xx, S_xy, ..., S_zz).

    d r = -g^T du - g^T dS h,  h = S^-1 (z - u),  g = S^-1 h / |h|
    """
    h = matrix @ (problem.points - u[:, None])
    g = matrix @ (h / np.linalg.norm(h, axis=0))
    pairs = [g[i] * h[j] + g[j] * h[i] if i != j else g[i] * h[i] for i, j in TRIANGLE]
    jacobian = -np.concatenate((g, pairs))
    return _squares(jacobian)


def _squares(rows: Array) -> Array:
    """rows rows^T of (9, n); by einsum, since a threaded product of so few rows costs more than it saves."""
    return np.asarray(np.einsum("in,jn->ij", rows, rows))


def _settled(problem: Problem, particle: Array, noise: float) -> Status:
    """Not converged when a Gauss-Newton step is longer than SETTLED standard deviations: |J step| / noise."""
    jacobian = problem.jacobian(particle)
    slope = np.einsum("ni,n->i", jacobian, problem.residuals(particle))
    decrement = float(np.sqrt(slope @ np.linalg.solve(_squares(jacobian.T), slope))) / noise
    if decrement <= SETTLED:
        return Status("ok")
    return Status(
        "not_converged",
        f"the search ended {decrement:.2g} standard deviations from the minimum of its own "
        "cost: use polish = true, or more iterations",
    )
