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

    wider: covariance (k, k) of c; None where the stated ``N^+`` is right.
    """

    N: Array
    g: Array
    wider: Array | None = None

    @classmethod
    def of(cls, products: Array) -> CoefficientEstimate:
        """The estimate from products (k + 1, k + 1) of whitened columns and, last, the target."""
        return cls(products[:-1, :-1], products[:-1, -1])

    @cached_property
    def c(self) -> Array:
        """Coefficients (k,); zero along undetermined directions."""
        return inverse(self.N) @ self.g

    @cached_property
    def covariance(self) -> Array:
        """Covariance C (k, k) of the coefficients, without the form error."""
        return inverse(self.N) if self.wider is None else self.wider

    def gain(self, c: Array) -> float:
        """Nats explained by given coefficients (k,) under the stated error: ``c^T g - c^T N c / 2``."""
        return float(c @ self.g - c @ self.N @ c / 2)

    def inflation(self, c: Array) -> float:
        """Variance along coefficients (k,) over the stated variance: ``c^T N C N c / c^T N c``, at least one."""
        size = float(c @ self.N @ c)
        return max(1.0, float(c @ self.N @ self.covariance @ self.N @ c) / size) if size > 0 else 1.0


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

    ``Q = sum_i d_i^T (C_i + F)^-1 d_i``, ``d_i = c_i - c``, chi-square with ``sum_i rank N_i - rank N`` degrees of
    freedom, ``N = sum_i N_i``. form : share of the effect by which the form is in error from motion to motion, ``F =
    form^2 (c^T N c / k) N^+``: an error of that size in any direction. known : degrees of freedom of the error
    estimates; then Q over its degrees follows an F distribution. The covariance of c, ``N^+ (sum_i N_i C_i N_i) N^+``,
    excludes F, and grows with differences between recordings beyond their own errors.
    """
    common = pool_estimates(estimates)
    c, back = common.c, inverse(common.N)
    F = form**2 * float(c @ common.N @ c) / len(c) * back

    def squares(F: Array) -> float:
        off = [(one.N @ (one.c - c), one.N @ (one.covariance + F) @ one.N) for one in estimates]
        return sum(float(u @ inverse(error) @ u) for u, error in off)

    degrees = sum(rank(one.N) for one in estimates) - rank(common.N)
    Q, scatter = squares(F), max(1.0, squares(0.0 * F) / max(degrees, 1))
    tail = chi2.sf(Q, degrees) if known is None else f.sf(Q / max(degrees, 1), degrees, known)
    propagated = back @ np.sum([one.N @ one.covariance @ one.N for one in estimates], axis=0) @ back
    return Agreement(c, scatter * propagated, Q, degrees, float(tail) if degrees else 1.0)


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
    back = [inverse(one.N) @ R.T for one, R in zip(whole, roots, strict=True)]
    return [replace(one, wider=B @ S @ B.T) for one, B, S in zip(whole, back, spreads, strict=True)]


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
        one, along, size = estimates[i], float(c @ estimates[i].g), float(c @ estimates[i].N @ c)
        if along > 0 and 2 * along**2 > size * float(one.c @ one.g):
            ratios[i] = along / size, (one.inflation(c) / size) ** 0.5
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
