"""Coefficients of an effect in several recordings: pooled, compared, and predicted from the other recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.stats import chi2, f

from scenarios.arrays import Array

OPEN = 1e-9
"""Eigenvalue of the scaled information below which a combination of coefficients is undetermined."""


@dataclass(frozen=True)
class CoefficientEstimate:
    """Information N (k, k) and score g (k,) of k coefficients in one recording; ``c = N^+ g``.

    spread: covariance (k, k) of ``R c``, R (k, k) a root of N: the unit matrix where the stated error is right, also
    None.
    """

    N: Array
    g: Array
    R: Array | None = None
    spread: Array | None = None

    @cached_property
    def c(self) -> Array:
        """Coefficients (k,); zero along undetermined directions."""
        return inverse(self.N) @ self.g

    @property
    def covariance(self) -> Array:
        """Covariance (k, k) of the coefficients, without the form error."""
        if self.R is None or self.spread is None:
            return inverse(self.N)
        back = inverse(self.N) @ self.R.T
        return np.asarray(back @ self.spread @ back.T)

    def gain(self, c: Array) -> float:
        """Nats explained by given coefficients (k,) under the stated error: ``c^T g - c^T N c / 2``."""
        return float(c @ self.g - c @ self.N @ c / 2)

    def scaled_gain(self, c: Array) -> float:
        """Nats explained by coefficients (k,) times the best factor above zero, over their inflation."""
        along, size = float(c @ self.g), float(c @ self.N @ c)
        return along**2 / (2 * size * self.inflation(c)) if min(along, size) > 0 else 0.0

    def inflation(self, c: Array) -> float:
        """Variance along coefficients (k,) over the stated variance."""
        size = float(c @ self.N @ c)
        if self.R is None or self.spread is None or size <= 0:
            return 1.0
        u = self.R @ c
        return max(1.0, float(u @ self.spread @ u) / size)


@dataclass(frozen=True)
class Agreement:
    """Common coefficients c (k,) with covariance (k, k), and the test of agreement: Q, degrees of freedom, p."""

    c: Array
    covariance: Array
    chi2: float
    degrees: int
    p: float


def agreement(estimates: Sequence[CoefficientEstimate], form: float, known: int | None = None) -> Agreement:
    """Pool estimates into common coefficients, and test the differences.

    ``Q = sum_i u_i^T (spread_i + R_i F R_i^T)^-1 u_i``, ``u_i = R_i (c_i - c)``, chi-square with ``sum_i rank N_i -
    rank sum_i N_i`` degrees of freedom. form : share of the effect by which the form is in error from motion to motion,
    ``F = form^2 (c^T N c / k) N^+`` with N the mean information: an error of that size in any direction. known :
    degrees of freedom of the error estimates; then Q over its degrees follows an F distribution. The covariance of c
    excludes F, and grows with differences between recordings beyond their own errors.
    """
    common = pool_estimates(estimates)
    size, c = _coefficient_scale(common.N), common.c
    rooted = [_rooted(estimate, size) for estimate in estimates]
    F = form**2 * float(c @ common.N @ c) / len(c) * inverse(common.N)
    degrees = sum(rank(estimate.N) for estimate in estimates) - rank(common.N)
    Q, plain = (sum(_squared_distance(rooted_estimate, c, error) for rooted_estimate in rooted) for error in (F, 0 * F))
    spread = np.mean([spread for *_, spread in rooted], axis=0)
    wide = CoefficientEstimate(common.N, common.g, _root(common.N, size), spread)
    scatter = max(1.0, plain / max(degrees, 1))
    return Agreement(c, scatter * wide.covariance, Q, degrees, _tail_probability(Q, degrees, known))


def _rooted(estimate: CoefficientEstimate, size: Array) -> tuple[Array, Array, Array]:
    """Coefficients c (k,), root R (k, k) of the information, and covariance (k, k) of R c."""
    R = _root(estimate.N, size) if estimate.R is None else estimate.R
    return estimate.c, R, np.eye(len(estimate.c)) if estimate.spread is None else estimate.spread


def _squared_distance(estimate: tuple[Array, Array, Array], c: Array, F: Array) -> float:
    """Squared distance of an estimate's coefficients from c (k,), in units of spread and form error F (k, k)."""
    own, R, spread = estimate
    u = R @ (own - c)
    return float(u @ np.linalg.solve(spread + R @ F @ R.T, u))


def with_scatter(
    parts_of_each: Sequence[Sequence[CoefficientEstimate]], least: Sequence[float]
) -> list[CoefficientEstimate]:
    """Estimates of n recordings from m parts each, with errors widened by the scatter of the parts.

    Under the stated errors the squares of ``u_b = N^-1/2 (g_b - N_b c) sqrt(m / (m - 1))`` summed over parts b are the
    unit matrix. In directions with larger squares, averaged over the recordings, the spread grows by the same factor,
    and by `least` (n,) in any direction. Noise that is slow in the earth's frame has a spectrum in the body frame that
    follows the motion, and escapes any noise model.
    """
    whole = [pool_estimates(parts) for parts in parts_of_each]
    size = _coefficient_scale(pool_estimates(whole).N)
    roots = [_root(whole_estimate.N, size) for whole_estimate in whole]
    u = [
        R @ inverse(whole_estimate.N) @ (part.g - part.N @ whole_estimate.c)
        for R, whole_estimate, parts in zip(roots, whole, parts_of_each, strict=True)
        for part in parts
    ]
    m = len(parts_of_each[0])
    values, vectors = np.linalg.eigh(np.transpose(u) @ np.array(u) * m / (m - 1) / len(parts_of_each))
    spreads = [vectors * np.maximum(values, floor) @ vectors.T for floor in least]
    return [
        CoefficientEstimate(whole_estimate.N, whole_estimate.g, R, spread)
        for whole_estimate, R, spread in zip(whole, roots, spreads, strict=True)
    ]


def pool_estimates(estimates: Sequence[CoefficientEstimate]) -> CoefficientEstimate:
    """Joint estimate of one coefficient vector from all estimates."""
    return CoefficientEstimate(
        np.sum([estimate.N for estimate in estimates], axis=0), np.sum([estimate.g for estimate in estimates], axis=0)
    )


def predicted_by_others(estimates: Sequence[CoefficientEstimate]) -> Array:
    """Coefficients (n, k) for each of n recordings, estimated from all other recordings."""
    others_of_each = ([another for another in estimates if another is not estimate] for estimate in estimates)
    return np.array(
        [pool_estimates(others).c if others else np.zeros(len(estimates[0].g)) for others in others_of_each]
    )


def cross_predicted_gains(estimates: Sequence[CoefficientEstimate]) -> Array:
    """Nats (n,) explained in each recording by the other recordings' coefficients under the stated errors."""
    return np.array([estimate.gain(c) for estimate, c in zip(estimates, predicted_by_others(estimates), strict=True)])


def size_ratio(estimate: CoefficientEstimate, c: Array) -> tuple[float, float] | None:
    """Best factor a of coefficients (k,) for an estimate, ``a = c^T g / c^T N c``, and its standard deviation.

    None where the coefficients explain nothing whatever the factor.
    """
    information = float(c @ estimate.N @ c)
    return (
        (float(c @ estimate.g) / information, (estimate.inflation(c) / information) ** 0.5) if information > 0 else None
    )


def inverse(N: Array) -> Array:
    """Pseudo-inverse of an information matrix (k, k), independent of the units of the coefficients."""
    size = _coefficient_scale(N)
    return np.asarray(np.linalg.pinv(N / np.outer(size, size), rcond=OPEN, hermitian=True) / np.outer(size, size))


def rank(N: Array) -> int:
    """Number of coefficient combinations determined by an information matrix (k, k)."""
    size = _coefficient_scale(N)
    values = np.linalg.eigvalsh(N / np.outer(size, size))
    return int(np.count_nonzero(values > OPEN * values.max()))


def _root(N: Array, size: Array) -> Array:
    """A root R (k, k) of an information matrix, ``R^T R = N``, symmetric for coefficients in units of 1 / size (k,)."""
    values, vectors = np.linalg.eigh(N / np.outer(size, size))
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)) @ vectors.T * size)


def _tail_probability(Q: float, degrees: int, known: int | None) -> float:
    if degrees == 0:
        return 1.0
    return float(chi2.sf(Q, degrees) if known is None else f.sf(Q / degrees, degrees, known))


def _coefficient_scale(N: Array) -> Array:
    """Root of the diagonal (k,), one for a coefficient without information."""
    diagonal = np.diag(N)
    return np.asarray(np.sqrt(np.where(diagonal > 0, diagonal, 1.0)))
