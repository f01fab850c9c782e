"""TWOSTEP: the centred linear estimate, then a few corrections by the centre term."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from calib.base import Calibrator
from calib.models.ellipsoid import (
    EllipsoidFit,
    Standardised,
    is_definite,
    mean_square_error,
    norm_coordinates,
    symmetric_root,
)
from calib.models.quadric import EVEN, ROUNDING_VARIANCE, design, shape_matrix, weighted_scatter
from calib.observability import Extent, unobservable
from calib.reference import Reference
from calib.result import Calibration, Status
from calib.settings import Count, Positive
from recordings import Recording
from scenarios.arrays import Array
from scenarios.kernel_cache import njit
from scenarios.text import figure

HALVINGS = 30
PART = 100_000
"""Points taken at once where rows are formed, to bound the memory."""


@dataclass(frozen=True)
class TwoStep(Calibrator):
    """Offset and symmetric S by the attitude-independent two-step estimator.

    |T (m - b)| = F,  A = T T = I + E,  p = -A b:
    z = x^T A x + 2 p^T x + p^T A^-1 p - 1 = v,  var v = 4 sigma^2 |T y|^2,  y = T (x - b),  <v> = sigma^2 |T|^2

    Step one drops the weighted mean of z, and with it the only term that is not linear in (A, p). Where the reference
    strength does not vary, A = 0 would then fit perfectly, so tr A is held and its size taken from the mean. Step two
    is Gauss-Newton on the whole cost, step one's information matrix plus the centre term W (mean z - <v>)^2, until a
    step's length in its own covariance is below `tolerance`; weights and <v> follow the estimate round by round, until
    a round moves it by less than that too. T = A^1/2 symmetric (I + D of the paper): the strength says nothing of a
    rotation.
    Claimed covariance: inverse information plus the square of the bias of second order by noise in x.
    [AlonsoShuster2002] for noise in the corrected field; here noise is on the measurement.
    """

    name: ClassVar[str] = "twostep"
    summary: ClassVar[str] = "9 parameters from the field strength: centred linear step, then Gauss-Newton; no attitude"
    min_samples: ClassVar[int] = 10
    rounds: Count = 6
    iterations: Count = 30
    tolerance: Positive = 1e-3

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        scaled = Standardised.of(recording.mag_nT)
        found = self.estimate(scaled.x)
        fit = None if found is None else found.fit(scaled.x)
        if found is None or fit is None:
            return unobservable(Extent.of(recording.mag_nT).thinnest, "the centred estimate is not an ellipsoid")
        status = Status.settled(
            found.move < self.tolerance,
            f"after {len(found.history)} steps in at most {self.rounds} rounds the estimate still moves by "
            f"{figure(found.move, 2)} standard deviations, the limit is {self.tolerance:g}",
        )
        return scaled.calibration(self.name, status, fit, reference)

    def estimate(self, x: Array) -> TwoStepEstimate | None:
        """The estimate from standardised points (n, 3); None when step one's is not an ellipsoid."""
        theta = first_step(x)
        if theta is None:
            return None
        history: list[float] = []
        variance = 0.0
        for _ in range(self.rounds):
            before = theta
            centred = Centred.of(x, theta, variance * float(np.trace(shape_matrix(theta))))
            theta, lengths = self._second_step(centred, theta)
            history += lengths
            variance = centred.variance(theta)
            round_move = centred.length(theta, theta - before)
            if round_move < self.tolerance:
                break
        return TwoStepEstimate(theta, centred, max(round_move, history[-1]), tuple(history))

    def _second_step(self, centred: Centred, theta: Array) -> tuple[Array, list[float]]:
        """Where the steps from theta (9,) end, and the length of each."""
        lengths: list[float] = []
        for _ in range(self.iterations):
            new = centred.step(theta)
            lengths.append(centred.length(new, new - theta))
            theta = new
            if lengths[-1] < self.tolerance:
                break
        return theta, lengths


@dataclass(frozen=True)
class TwoStepEstimate:
    """theta (9,) = (A's six as `shape_matrix` has them, p), the cost it minimises, and the length of each step.

    move: how far theta still moved at the end, in its standard deviations, by the last round or the last step in it.
    """

    theta: Array
    centred: Centred
    move: float
    history: tuple[float, ...]

    @property
    def noise_std(self) -> float:
        """Noise of a component of x."""
        return float(np.sqrt(self.centred.variance(self.theta)))

    @property
    def quadric(self) -> Array:
        """theta with the constant that puts |h| at one (10,)."""
        return np.append(self.theta, -self.theta[6:] @ centre_of(self.theta) - 1.0)

    def start(self) -> Array:
        """Norm coordinates (9,): T = A^1/2 and c = T b."""
        T = symmetric_root(shape_matrix(self.theta))
        return norm_coordinates(T, T @ centre_of(self.theta))

    def fit(self, x: Array) -> EllipsoidFit | None:
        """The ellipsoid and its mean square error; None where the estimate is no ellipsoid."""
        theta, variance = self.theta, self.centred.variance(self.theta)
        parts = np.split(x, range(PART, len(x), PART))
        bias = sum((_expected_gradient(theta, part) for part in parts), np.zeros(9))
        error = mean_square_error(self.centred.information(theta), variance, bias=bias)
        constant = np.vstack((np.eye(9), centre_gradient(theta)))
        return EllipsoidFit.of_quadric(
            self.quadric, constant @ error @ constant.T, float(np.sqrt(variance)), self.history
        )


@dataclass(frozen=True)
class Centred:
    """The cost |R theta|^2 + W (mean row . theta + p^T A^-1 p - 1 - <v>)^2 of n points, in ten rows.

    theta as in `TwoStepEstimate`; R (9, 9) with R^T R the scatter of the centred rows.
    """

    R: Array
    mean: Array
    weight: float
    noise_mean: float
    n: int

    @classmethod
    def of(cls, x: Array, theta: Array, noise_mean: float) -> Centred:
        """From points (n, 3), weighted by 1 / (4 |A x + p|^2) at theta."""
        return cls(*centred_rows(x, np.append(theta, 0.0)), noise_mean, len(x))

    def centre(self, theta: Array) -> float:
        """Mean residual, nothing but noise at the truth."""
        return self._terms(theta)[1]

    def cost(self, theta: Array) -> float:
        """The whole cost, n times the noise variance at the minimum."""
        return self._terms(theta)[0]

    def _terms(self, theta: Array) -> tuple[float, float]:
        found: tuple[float, float] = _centred_cost(self.R, self.mean, self.weight, self.noise_mean, theta)
        return found

    def variance(self, theta: Array) -> float:
        """Noise variance of a component of x."""
        return self.cost(theta) / max(self.n - 9, 1)

    def information(self, theta: Array) -> Array:
        """Gauss-Newton's matrix (9, 9)."""
        row = self.mean + centre_gradient(theta)
        return np.asarray(self.R.T @ self.R + self.weight * np.outer(row, row))

    def step(self, theta: Array) -> Array:
        """One Gauss-Newton step, halved until A stays positive definite and the cost does not rise."""
        jacobian = np.vstack((self.R, np.sqrt(self.weight) * (self.mean + centre_gradient(theta))))
        residual = np.append(self.R @ theta, np.sqrt(self.weight) * self.centre(theta))
        change = np.linalg.lstsq(jacobian, -residual, rcond=None)[0]
        cost = self.cost(theta)
        for halving in range(HALVINGS):
            new = theta + change / 2**halving
            if is_definite(shape_matrix(new)) and self.cost(new) <= cost:
                return np.asarray(new)
        return theta

    def length(self, theta: Array, change: Array) -> float:
        """A change's length in standard deviations of theta."""
        variance = self.variance(theta) + ROUNDING_VARIANCE
        return float(np.sqrt(change @ self.information(theta) @ change / variance))


def centred_rows(x: Array, theta: Array) -> tuple[Array, Array, float]:
    """R (9, 9) of the cost |R theta|^2 of centred rows, their mean (9,), and the sum of the weights at theta (10,)."""
    scatter = weighted_scatter(x, theta)
    weight = float(scatter[9, 9])
    mean = scatter[9, :9] / weight
    squares, axes = np.linalg.eigh(scatter[:9, :9] - weight * np.outer(mean, mean))
    return np.sqrt(np.maximum(squares, 0.0))[:, None] * axes.T, mean, weight


def first_step(x: Array) -> Array | None:
    """The centred estimate (9,) of (A, p) from points (n, 3); None when A is not positive definite.

    min sum (row - mean row)^2 . theta over tr A = 3, linear; then theta / (mean row . theta + p^T A^-1 p).
    """
    R, mean, _ = centred_rows(x, EVEN)
    free = np.column_stack((R[:, 0] - R[:, 2], R[:, 1] - R[:, 2], R[:, 3:]))
    solution = np.linalg.lstsq(free, -R[:, :3].sum(axis=1), rcond=None)[0]
    a, b = solution[:2]
    theta = np.concatenate(([1 + a, 1 + b, 1 - a - b], solution[2:]))
    if not is_definite(shape_matrix(theta)):
        return None
    level = theta[6:] @ np.linalg.solve(shape_matrix(theta), theta[6:]) + mean @ theta
    return None if level <= 0 else np.asarray(theta / level)


@njit(cache=True)
def centre_of(theta: Array) -> Array:
    """b = -A^-1 p (3,), by cofactors; LinAlgError for a singular A."""
    a, b, c, f, g, h, p, q, r = theta[:9]
    aa, ab, ac = b * c - f * f, f * g - h * c, h * f - b * g
    det = a * aa + h * ab + g * ac
    if det == 0.0:
        raise np.linalg.LinAlgError("Singular matrix")
    bb, bc, cc = a * c - g * g, g * h - a * f, a * b - h * h
    centre: Array = np.array([aa * p + ab * q + ac * r, ab * p + bb * q + bc * r, ac * p + bc * q + cc * r]) / -det
    return centre


@njit(cache=True)
def centre_gradient(theta: Array) -> Array:
    """d (p^T A^-1 p) / d theta (9,): the design row of b, negative: dA gives -b^T dA b, dp gives -2 b^T dp."""
    x, y, z = centre_of(theta)
    return -np.array([x * x, y * y, z * z, 2 * y * z, 2 * x * z, 2 * x * y, 2 * x, 2 * y, 2 * z])


@njit(cache=True)
def _centred_cost(R: Array, mean: Array, weight: float, noise_mean: float, theta: Array) -> tuple[float, float]:
    """The cost of `Centred`, and the mean residual in its centre term."""
    b, total, centre = centre_of(theta), 0.0, -1.0 - noise_mean
    for i in range(9):
        row = 0.0
        for j in range(9):
            row += R[i, j] * theta[j]
        total += row * row
        centre += mean[i] * theta[i]
    for i in range(3):
        centre -= theta[6 + i] * b[i]
    return total + weight * centre * centre, centre


def _expected_gradient(theta: Array, x: Array) -> Array:
    """sum E[w v dz/dtheta] (9,) for noise of variance one on x, which varies v, dz/dtheta and the weight w together.

    w (2 (x g^T + g x^T) . dA + 4 g . dp) - 4 w (g^T A g / |g|^2) dz/dtheta,  g = A (x - b),  w = 1 / (4 |g|^2)
    """
    shape = shape_matrix(theta)
    g = (x - centre_of(theta)) @ shape
    square = np.einsum("ni,ni->n", g, g)
    weight = 1.0 / (4 * square)
    pairs = (weight[:, None] * x).T @ g
    both = 2 * (pairs + pairs.T)
    follows = np.einsum("ni,ni->n", g @ shape, g) / square**2
    rows = follows @ design(x) + follows.sum() * centre_gradient(theta)
    return np.asarray(np.concatenate((np.diag(both), 2 * both[[1, 0, 0], [2, 2, 1]], 4 * weight @ g)) - rows)
