"""Coefficients of an effect in several recordings: pooled, compared, and predicted from the other recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.stats import chi2, f

from scenarios.arrays import Array

OPEN = 1e-9
"""Eigenvalue of the scaled information below which a combination of coefficients is undetermined."""


@dataclass(frozen=True)
class CoefficientEstimate:
    """Information N (k, k) and score g (k,) of k coefficients in one recording; ``c = N^+ g``.

    wider: a root R (k, k) of N, and the covariance (k, k) of ``R c``; None where the stated error is right.
    """

    N: Array
    g: Array
    wider: tuple[Array, Array] | None = None

    @classmethod
    def of(cls, products: Array, inflation: float = 1.0) -> CoefficientEstimate:
        """The estimate from products (k + 1, k + 1) of whitened columns and, last, the target."""
        return cls(products[:-1, :-1] / inflation, products[:-1, -1] / inflation)

    @cached_property
    def c(self) -> Array:
        """Coefficients (k,); zero along undetermined directions."""
        return inverse(self.N) @ self.g

    @cached_property
    def error(self) -> tuple[Array, Array]:
        """A root R (k, k) of the information, and the covariance (k, k) of ``R c``."""
        return self.wider or (root(self.N), np.eye(len(self.g)))

    @property
    def covariance(self) -> Array:
        """Covariance (k, k) of the coefficients, without the form error."""
        R, spread = self.error
        back = inverse(self.N) @ R.T
        return np.asarray(back @ spread @ back.T)

    def gain(self, c: Array) -> float:
        """Nats explained by given coefficients (k,) under the stated error: ``c^T g - c^T N c / 2``."""
        return float(c @ self.g - c @ self.N @ c / 2)

    def scaled_gain(self, c: Array) -> float:
        """Nats explained by coefficients (k,) times the best factor above zero, over their inflation."""
        along, size = float(c @ self.g), float(c @ self.N @ c)
        return along**2 / (2 * size * self.inflation(c)) if min(along, size) > 0 else 0.0

    def inflation(self, c: Array) -> float:
        """Variance along coefficients (k,) over the stated variance."""
        R, spread = self.error
        size, u = float(c @ self.N @ c), R @ c
        return max(1.0, float(u @ spread @ u) / size) if size > 0 else 1.0


@dataclass(frozen=True)
class Agreement:
    """Common coefficients c (k,) with covariance (k, k), and the test of agreement: Q, degrees of freedom, p."""

    c: Array
    covariance: Array
    chi2: float
    degrees: int
    p: float


NOT_COMPARED = Agreement(np.zeros(0), np.zeros((0, 0)), 0.0, 0, 1.0)
"""The agreement of no estimates."""


def agreement(estimates: Sequence[CoefficientEstimate], form: float, known: int | None = None) -> Agreement:
    """Pool estimates into common coefficients, and test the differences.

    ``Q = sum_i u_i^T (spread_i + R_i F R_i^T)^-1 u_i``, ``u_i = R_i (c_i - c)``, chi-square with ``sum_i rank N_i -
    rank sum_i N_i`` degrees of freedom. form : share of the effect by which the form is in error from motion to motion,
    ``F = form^2 (c^T N c / k) N^+`` with N the mean information: an error of that size in any direction. known :
    degrees of freedom of the error estimates; then Q over its degrees follows an F distribution. The covariance of c
    excludes F, and grows with differences between recordings beyond their own errors.
    """
    common = pool_estimates(estimates)
    c, Q, plain = common.c, 0.0, 0.0
    F = form**2 * float(c @ common.N @ c) / len(c) * inverse(common.N)
    for estimate in estimates:
        R, spread = estimate.error
        u = R @ (estimate.c - c)
        Q += float(u @ np.linalg.solve(spread + R @ F @ R.T, u))
        plain += float(u @ np.linalg.solve(spread, u))
    degrees = sum(rank(estimate.N) for estimate in estimates) - rank(common.N)
    spread = np.mean([estimate.error[1] for estimate in estimates], axis=0)
    wide = replace(common, wider=(common.error[0], spread))
    scatter, per_degree = max(1.0, plain / max(degrees, 1)), Q / max(degrees, 1)
    tail = chi2.sf(Q, degrees) if known is None else f.sf(per_degree, degrees, known)
    return Agreement(c, scatter * wide.covariance, Q, degrees, float(tail) if degrees else 1.0)


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
    size = _size(pool_estimates(whole).N)
    roots = [root(one.N, size) for one in whole]
    u = [
        R @ inverse(one.N) @ (part.g - part.N @ one.c)
        for R, one, parts in zip(roots, whole, parts_of_each, strict=True)
        for part in parts
    ]
    m = len(parts_of_each[0])
    values, vectors = np.linalg.eigh(np.transpose(u) @ np.array(u) * m / (m - 1) / len(parts_of_each))
    spreads = [vectors * np.maximum(values, floor) @ vectors.T for floor in least]
    return [replace(one, wider=(R, spread)) for one, R, spread in zip(whole, roots, spreads, strict=True)]


def pool_estimates(estimates: Sequence[CoefficientEstimate]) -> CoefficientEstimate:
    """Joint estimate of one coefficient vector from all estimates."""
    return CoefficientEstimate(
        np.sum([one.N for one in estimates], axis=0), np.sum([one.g for one in estimates], axis=0)
    )


def predicted_by_others(estimates: Mapping[int, CoefficientEstimate]) -> dict[int, Array]:
    """Coefficients (k,) for each recording, estimated from all other recordings; zero without others."""
    without = {i: [other for j, other in estimates.items() if j != i] for i in estimates}
    return {i: pool_estimates(others).c if others else 0 * estimates[i].g for i, others in without.items()}


def cross_predicted_gain(estimates: Sequence[CoefficientEstimate]) -> float:
    """Nats explained in all recordings together by the other recordings' coefficients under the stated errors."""
    predicted = predicted_by_others(dict(enumerate(estimates)))
    return sum(estimate.gain(predicted[i]) for i, estimate in enumerate(estimates))


def size_ratios(estimates: Mapping[int, CoefficientEstimate]) -> dict[int, tuple[float, float]]:
    """Size of each estimate over the size c of all others, ``a = c^T g / c^T N c``, with its standard deviation.

    Estimates that go less than half in the direction of the others have no ratio.
    """
    ratios = {}
    for i, c in predicted_by_others(estimates).items():
        estimate, information = estimates[i], float(c @ estimates[i].N @ c)
        if 2 * estimate.scaled_gain(c) > estimate.scaled_gain(estimate.c):
            ratios[i] = float(c @ estimate.g) / information, (estimate.inflation(c) / information) ** 0.5
    return ratios


def inverse(N: Array) -> Array:
    """Pseudo-inverse of an information matrix (k, k), independent of the units of the coefficients."""
    units = np.outer(size := _size(N), size)
    return np.asarray(np.linalg.pinv(N / units, rcond=OPEN, hermitian=True) / units)


def rank(N: Array) -> int:
    """Number of coefficient combinations determined by an information matrix (k, k)."""
    return int(np.linalg.matrix_rank(N / np.outer(size := _size(N), size), hermitian=True, rtol=OPEN))


def root(N: Array, size: Array | None = None) -> Array:
    """A root R (k, k) of a matrix, ``R^T R = N``, symmetric in units of `size` (k,), by default the diagonal's root."""
    size = _size(N) if size is None else size
    values, vectors = np.linalg.eigh(N / np.outer(size, size))
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)) @ vectors.T * size)


def _size(N: Array) -> Array:
    """Root of the diagonal (k,), one for a coefficient without information."""
    diagonal = np.diag(N)
    return np.asarray(np.sqrt(np.where(diagonal > 0, diagonal, 1.0)))
