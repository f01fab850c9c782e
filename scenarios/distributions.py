"""Distributions of the values that differ from run to run: draws, and the extremes to expect.

A distribution draws a replacement for a number, vector or matrix of the scenario. A parameter that is a number serves
every component; a parameter with the value's shape has an entry for each component.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from scenarios.arrays import Array

MOST_SIGMAS = 6.0
"""Standard deviations to the extremes of a normal distribution: one draw of 5e8 lies beyond."""
MOST_TRIES = 1000
"""Draws after which a truncated distribution counts as empty between its bounds."""


class Distribution(ABC):
    """A distribution from which a value is drawn."""

    form: ClassVar[str]
    """The TOML form, for messages and documentation."""
    whole: ClassVar[bool] = False
    """Whether the components are drawn together, so that no single component can be drawn again."""

    @abstractmethod
    def problem(self, value: Array) -> str:
        """Return what is wrong with the parameters, alone or for the shape of `value`; empty if nothing is wrong."""

    @abstractmethod
    def draw(self, value: Array, rng: np.random.Generator) -> Array:
        """Draw a replacement for `value`, of equal shape."""

    @abstractmethod
    def ends(self, value: Array) -> tuple[Array, ...]:
        """Return the extremes to expect of a draw, of the shape of `value`."""


@dataclass(frozen=True)
class _Between(Distribution):
    """A distribution between low and high."""

    low: Array
    high: Array

    def problem(self, value: Array) -> str:
        return _shapes(value, self.low, self.high) or _order(self.low, self.high, self.form)

    def ends(self, value: Array) -> tuple[Array, ...]:
        return tuple(np.broadcast_to(end, value.shape) for end in (self.low, self.high))


class Uniform(_Between):
    """Uniform between low and high."""

    form = "uniform = [low, high]"

    def draw(self, value: Array, rng: np.random.Generator) -> Array:
        return np.asarray(rng.uniform(self.low, self.high, value.shape))


class LogUniform(_Between):
    """Uniform logarithm between low and high: every factor of two is equally likely."""

    form = "log_uniform = [low, high]"

    def problem(self, value: Array) -> str:
        return super().problem(value) or ("" if np.all(self.low > 0) else "low must be above zero")

    def draw(self, value: Array, rng: np.random.Generator) -> Array:
        share = rng.random(value.shape)
        drawn = _exp((1 - share) * _log(self.low) + share * _log(self.high))
        return np.clip(drawn, self.low, self.high)


@dataclass(frozen=True)
class Normal(Distribution):
    """Normal, by mean and standard deviation."""

    mean: Array
    std: Array
    form = "normal = [mean, std]"

    def problem(self, value: Array) -> str:
        return _shapes(value, self.mean, self.std) or _not_negative(self.std)

    def draw(self, value: Array, rng: np.random.Generator) -> Array:
        return np.asarray(rng.normal(self.mean, self.std, value.shape))

    def ends(self, value: Array) -> tuple[Array, ...]:
        return tuple(np.broadcast_to(self.mean + k * self.std, value.shape) for k in (-MOST_SIGMAS, MOST_SIGMAS))


@dataclass(frozen=True)
class LogNormal(Distribution):
    """``median exp(sigma n)``, n standard normal: sigma is the standard deviation of the natural logarithm."""

    median: Array
    sigma: Array
    form = "log_normal = [median, sigma]"

    def problem(self, value: Array) -> str:
        positive = "" if np.all(self.median > 0) else "the median must be above zero"
        return _shapes(value, self.median, self.sigma) or positive or _not_negative(self.sigma)

    def draw(self, value: Array, rng: np.random.Generator) -> Array:
        return self.median * _exp(self.sigma * rng.standard_normal(value.shape))

    def ends(self, value: Array) -> tuple[Array, ...]:
        return tuple(
            np.broadcast_to(self.median * _exp(k * self.sigma), value.shape) for k in (-MOST_SIGMAS, MOST_SIGMAS)
        )


@dataclass(frozen=True)
class RelativeNormal(Distribution):
    """``x (1 + s n)``, n standard normal, for each component x of the scenario's value."""

    std: Array
    form = "relative_normal = std"

    def problem(self, value: Array) -> str:
        return _shapes(value, self.std) or _not_negative(self.std)

    def draw(self, value: Array, rng: np.random.Generator) -> Array:
        return np.asarray(value * (1.0 + self.std * rng.standard_normal(value.shape)))

    def ends(self, value: Array) -> tuple[Array, ...]:
        return tuple(value * (1.0 + k * self.std) for k in (-MOST_SIGMAS, MOST_SIGMAS))


@dataclass(frozen=True)
class OnSphere(Distribution):
    """A vector of three components: direction uniform on the sphere, length uniform between low and high."""

    low: Array
    high: Array
    form = "on_sphere = radius, or [low, high]"
    whole = True

    def problem(self, value: Array) -> str:
        if value.shape != (3,):
            return "on_sphere draws a vector of three numbers"
        return _not_negative(self.low, "the radius") or _order(self.low, self.high, self.form)

    def draw(self, value: Array, rng: np.random.Generator) -> Array:
        direction = rng.standard_normal(3)
        radius = rng.uniform(self.low, self.high)
        return np.asarray(direction * (radius / math.hypot(*direction)))

    def ends(self, value: Array) -> tuple[Array, ...]:
        return tuple(sign * float(self.high) * axis for axis in np.eye(3) for sign in (-1.0, 1.0))


@dataclass(frozen=True)
class Correlated(Distribution):
    """``mean + L n``, L L^T the covariance (k, k), n standard normal: a vector, or a matrix row by row."""

    mean: Array
    covariance: Array
    form = "correlated = { mean = [...], covariance = [[...], ...] }"
    whole = True

    def problem(self, value: Array) -> str:
        count = value.size
        if self.mean.shape not in ((count,), value.shape):
            return f"the mean has the shape {self.mean.shape}, the value has {value.shape}"
        if self.covariance.shape != (count, count):
            return f"the covariance must have {count} rows of {count} numbers"
        if not np.array_equal(self.covariance, self.covariance.T):
            return "the covariance is not symmetric"
        return "" if cholesky(self.covariance) is not None else "the covariance is not positive definite"

    def draw(self, value: Array, rng: np.random.Generator) -> Array:
        factor, normal = cholesky(self.covariance), rng.standard_normal(value.size)
        assert factor is not None, "checked when the scenario is loaded"
        moved = np.array([math.fsum(row * normal) for row in factor])
        return np.asarray((self.mean.ravel() + moved).reshape(value.shape))

    def ends(self, value: Array) -> tuple[Array, ...]:
        std = np.sqrt(np.diag(self.covariance))
        return tuple((self.mean.ravel() + k * std).reshape(value.shape) for k in (-MOST_SIGMAS, MOST_SIGMAS))


@dataclass(frozen=True)
class Truncated(Distribution):
    """A distribution with bounds: components outside the bounds are drawn again."""

    of: Distribution
    low: Array
    high: Array
    form = "truncated = [low, high]"

    def problem(self, value: Array) -> str:
        own = _shapes(value, self.low, self.high) or _order(self.low, self.high, self.form)
        if problem := own or self.of.problem(value):
            return problem
        try:
            self.draw(value, np.random.default_rng(0))
        except ValueError as error:
            return str(error)
        return ""

    def draw(self, value: Array, rng: np.random.Generator) -> Array:
        drawn = self.of.draw(value, rng)
        for _ in range(MOST_TRIES):
            outside = (drawn < self.low) | (drawn > self.high)
            if not outside.any():
                return drawn
            again = self.of.draw(value, rng)
            drawn = again if self.of.whole else np.where(outside, again, drawn)
        raise ValueError(f"none of {MOST_TRIES} draws lies between the bounds of {self.form}")

    def ends(self, value: Array) -> tuple[Array, ...]:
        return tuple(np.clip(end, self.low, self.high) for end in self.of.ends(value))


@dataclass(frozen=True)
class Symmetric(Distribution):
    """A symmetric matrix: the upper triangle of a draw, mirrored into the lower."""

    of: Distribution
    form = "symmetric = true"

    def problem(self, value: Array) -> str:
        if value.ndim != 2 or value.shape[0] != value.shape[1]:
            return "symmetric = true asks for a square matrix"
        return self.of.problem(value)

    def draw(self, value: Array, rng: np.random.Generator) -> Array:
        return _mirrored(self.of.draw(value, rng))

    def ends(self, value: Array) -> tuple[Array, ...]:
        return tuple(map(_mirrored, self.of.ends(value)))


@dataclass(frozen=True)
class Choice:
    """A choice between equally likely values: numbers, text or dates."""

    options: tuple[Any, ...]
    form: ClassVar[str] = "choice = [...]"

    def draw(self, rng: np.random.Generator) -> Any:
        """Draw one of the values."""
        return self.options[int(rng.integers(len(self.options)))]


def cholesky(matrix: Array) -> Array | None:
    """Return the lower L with L L^T = matrix (n, n); None for a matrix that is not positive definite.

    The sums have a fixed order, since LAPACK's last bits depend on the processor and draws decide a dataset's bytes.
    """
    lower = np.zeros(matrix.shape)
    for i in range(len(matrix)):
        for j in range(i + 1):
            remainder = matrix[i, j] - math.fsum(lower[i, :j] * lower[j, :j])
            if i == j and remainder <= 0:
                return None
            lower[i, j] = math.sqrt(remainder) if i == j else remainder / lower[j, j]
    return lower


def _mirrored(matrix: Array) -> Array:
    return np.asarray(np.triu(matrix) + np.triu(matrix, 1).T)


def _exp(x: Any) -> Array:
    """Return exp(x) by extended precision, equal on every processor."""
    return np.exp(np.asarray(x, dtype=np.longdouble)).astype(np.float64)


def _log(x: Any) -> Any:
    return np.log(np.asarray(x, dtype=np.longdouble))


def _shapes(value: Array, *parameters: Array) -> str:
    wrong = [p.shape for p in parameters if p.shape not in ((), value.shape)]
    if not wrong:
        return ""
    needed = f"one, or {_size(value.shape)}" if value.shape else "one number"
    return f"found {_size(wrong[0])} where the value needs {needed}"


def _size(shape: Iterable[int]) -> str:
    return " rows of ".join(map(str, shape)) + " numbers" if shape else "one number"


def _order(low: Array, high: Array, form: str) -> str:
    return "" if np.all(low <= high) else f"{form} has low above high"


def _not_negative(size: Array, what: str = "the standard deviation") -> str:
    return "" if np.all(size >= 0) else f"{what} is negative"
