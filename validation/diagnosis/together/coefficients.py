"""One effect's coefficients in several recordings: pooled, held against each other, and foretold by the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from sim.state import Array

OPEN = 1e-9
"""Eigenvalue of scaled information below which a combination of coefficients is open."""


@dataclass(frozen=True)
class Estimate:
    """What one recording says of k coefficients: information N (k, k) and score g (k,); ``c = N^+ g``, covariance N^+.

    Both are over the inflation by chance, so that the covariance is the whole error but for that of the form.
    """

    N: Array
    g: Array

    @property
    def c(self) -> Array:
        """Coefficients (k,); zero along what the recording leaves open."""
        return inverse(self.N) @ self.g

    @property
    def covariance(self) -> Array:
        """Covariance (k, k) of the coefficients, without that of the form."""
        return inverse(self.N)

    def gain(self, c: Array) -> float:
        """Nats that coefficients (k,) as they are explain: ``c^T g - c^T N c / 2``."""
        return float(c @ self.g - c @ self.N @ c / 2)

    @property
    def present(self) -> float:
        """Probability that coefficients of zero give as much by chance."""
        return float(chi2.sf(2 * self.gain(self.c), rank(self.N)))

    def blurred(self, form: Array) -> Estimate:
        """The same with a further covariance F (k, k) of the coefficients: ``W = (I + N F)^-1 N``."""
        back = np.linalg.inv(np.eye(len(self.g)) + self.N @ form)
        return Estimate(back @ self.N, back @ self.g)


@dataclass(frozen=True)
class Agreement:
    """One coefficient for all: c (k,), its covariance (k, k), and whether they agree: chi-square, its degrees, p."""

    c: Array
    covariance: Array
    chi2: float
    degrees: int
    p: float


def agreement(several: Sequence[Estimate], form: float) -> Agreement:
    """The common coefficient of estimates and the chi-square of their differences from it.

    ``Q = sum_i c_i^T W_i c_i - c^T (sum_i W_i) c``, chi-square of ``sum_i rank N_i - rank sum_i N_i`` degrees.
    form : share of the effect by which its form is in error on one motion or another; it widens every W_i by
    ``F = form^2 (c^T N c / k) N^+`` with N the mean information, an error of that size in any direction. The common
    coefficient and its covariance are without it; the covariance grows with what the recordings differ beyond their
    own errors.
    """
    size = _size(several)
    scaled = [Estimate(one.N / np.outer(size, size), one.g / size) for one in several]
    common = _common(scaled)
    mean = np.mean([one.N for one in scaled], axis=0)
    F = form**2 * float(common.c @ mean @ common.c) / len(size) * inverse(mean)
    degrees = sum(rank(one.N) for one in scaled) - rank(common.N)
    Q = _differences([one.blurred(F) for one in scaled])
    p = float(chi2.sf(Q, degrees)) if degrees > 0 else 1.0
    scatter = max(1.0, _differences(scaled) / degrees) if degrees > 0 else 1.0
    return Agreement(common.c / size, scatter * common.covariance / np.outer(size, size), Q, degrees, p)


def _differences(several: Sequence[Estimate]) -> float:
    return max(2 * (sum(one.gain(one.c) for one in several) - (common := _common(several)).gain(common.c)), 0.0)


def foretold(several: Sequence[Estimate]) -> Array:
    """Coefficients (n, k) for each of n recordings that all the others together give."""
    size = _size(several)
    scaled = [Estimate(one.N / np.outer(size, size), one.g / size) for one in several]
    rest = ([other for other in scaled if other is not one] for one in scaled)
    return np.array([_common(others).c / size if others else np.zeros(len(size)) for others in rest])


def left_out_gains(several: Sequence[Estimate]) -> Array:
    """Nats (n,) that the others' coefficients, as they are, explain in each recording."""
    return np.array([one.gain(c) for one, c in zip(several, foretold(several), strict=True)])


def size_over(one: Estimate, c: Array) -> tuple[float, float] | None:
    """The factor a by which coefficients (k,) best explain an estimate, ``a = c^T g / c^T N c``, and its std.

    None where they explain nothing there whatever the factor.
    """
    information = float(c @ one.N @ c)
    return (float(c @ one.g) / information, information**-0.5) if information > 0 else None


def inverse(N: Array) -> Array:
    """Pseudo-inverse of an information matrix (k, k), whatever the units of its coefficients."""
    size = _scale(N)
    return np.asarray(np.linalg.pinv(N / np.outer(size, size), rcond=OPEN, hermitian=True) / np.outer(size, size))


def rank(N: Array) -> int:
    """How many combinations of coefficients an information matrix (k, k) determines."""
    size = _scale(N)
    values = np.linalg.eigvalsh(N / np.outer(size, size))
    return int(np.count_nonzero(values > OPEN * max(float(values.max(initial=0.0)), 1e-300))) if N.any() else 0


def _common(several: Sequence[Estimate]) -> Estimate:
    return Estimate(sum((one.N for one in several), np.zeros_like(several[0].N)), _total([one.g for one in several]))


def _total(parts: Sequence[Array]) -> Array:
    return np.asarray(np.sum(parts, axis=0))


def _size(several: Sequence[Estimate]) -> Array:
    """Scale (k,) of each coefficient's information over all recordings."""
    return _scale(_common(several).N)


def _scale(N: Array) -> Array:
    """Root of the diagonal (k,), one where a coefficient has no information."""
    diagonal = np.diag(N)
    return np.asarray(np.sqrt(np.where(diagonal > 0, diagonal, 1.0)))
