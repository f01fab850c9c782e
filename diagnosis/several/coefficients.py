"""One effect's coefficients in several recordings: pooled, held against each other, and foretold by the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.stats import chi2, f

from scenarios.arrays import Array

OPEN = 1e-9
"""Eigenvalue of scaled information below which a combination of coefficients is open."""


@dataclass(frozen=True)
class CoefficientEstimate:
    """What one recording says of k coefficients: information N (k, k) and score g (k,); ``c = N^+ g``.

    spread: covariance (k, k) of ``R c``, R (k, k) the root of N: one where the stated error is right; None: it is.
    """

    N: Array
    g: Array
    R: Array | None = None
    spread: Array | None = None

    @cached_property
    def c(self) -> Array:
        """Coefficients (k,); zero along what the recording leaves open."""
        return inverse(self.N) @ self.g

    @property
    def covariance(self) -> Array:
        """Covariance (k, k) of the coefficients, without that of the form."""
        if self.R is None or self.spread is None:
            return inverse(self.N)
        back = inverse(self.N) @ self.R.T
        return np.asarray(back @ self.spread @ back.T)

    def gain(self, c: Array) -> float:
        """Nats that coefficients (k,) as they are explain under the stated error: ``c^T g - c^T N c / 2``."""
        return float(c @ self.g - c @ self.N @ c / 2)

    def scaled_gain(self, c: Array) -> float:
        """Nats that coefficients (k,) times the factor above zero that is best explain, over their inflation."""
        along, size = float(c @ self.g), float(c @ self.N @ c)
        return along**2 / (2 * size * self.inflation(c)) if min(along, size) > 0 else 0.0

    def inflation(self, c: Array) -> float:
        """Variance along coefficients (k,) over the stated one."""
        size = float(c @ self.N @ c)
        if self.R is None or self.spread is None or size <= 0:
            return 1.0
        u = self.R @ c
        return max(1.0, float(u @ self.spread @ u) / size)


@dataclass(frozen=True)
class Agreement:
    """One coefficient for all: c (k,), its covariance (k, k), and whether they agree: Q, its degrees, probability p."""

    c: Array
    covariance: Array
    chi2: float
    degrees: int
    p: float


def agreement(several: Sequence[CoefficientEstimate], form: float, known: int | None = None) -> Agreement:
    """The common coefficient of estimates, and their differences from it.

    ``Q = sum_i u_i^T (spread_i + R_i F R_i^T)^-1 u_i``, ``u_i = R_i (c_i - c)``, chi-square of
    ``sum_i rank N_i - rank sum_i N_i`` degrees. form : share of the effect by which its form is in error on one motion
    or another, ``F = form^2 (c^T N c / k) N^+`` with N the mean information: an error of that size in any direction.
    known : degrees of freedom that the errors are known with; then Q over its degrees is an F. The covariance of c is
    without F, and grows with what the recordings differ beyond their own errors.
    """
    common = pooled(several)
    size, c = _scale(common.N), common.c
    rooted = [_rooted(one, size) for one in several]
    F = form**2 * float(c @ common.N @ c) / len(c) * inverse(common.N)
    degrees = sum(rank(one.N) for one in several) - rank(common.N)
    Q, plain = (sum(_distance(each, c, error) for each in rooted) for error in (F, 0 * F))
    spread = np.mean([spread for *_, spread in rooted], axis=0)
    wide = CoefficientEstimate(common.N, common.g, _root(common.N, size), spread)
    scatter = max(1.0, plain / max(degrees, 1))
    return Agreement(c, scatter * wide.covariance, Q, degrees, _odds(Q, degrees, known))


def _rooted(one: CoefficientEstimate, size: Array) -> tuple[Array, Array, Array]:
    """Coefficients c (k,), root R (k, k) of the information, and the covariance (k, k) of R c."""
    R = _root(one.N, size) if one.R is None else one.R
    return one.c, R, np.eye(len(one.c)) if one.spread is None else one.spread


def _distance(one: tuple[Array, Array, Array], c: Array, F: Array) -> float:
    """Square of the distance of an estimate's coefficients from others (k,), in units of spread and form F (k, k)."""
    own, R, spread = one
    u = R @ (own - c)
    return float(u @ np.linalg.solve(spread + R @ F @ R.T, u))


def with_scatter(several: Sequence[Sequence[CoefficientEstimate]], least: Sequence[float]) -> list[CoefficientEstimate]:
    """Estimates of n recordings from their m parts each, with the error that the parts' scores show.

    Were the stated error right, the squares of ``u_b = N^-1/2 (g_b - N_b c) sqrt(m / (m - 1))`` summed over the parts b
    would be I. Where they are more in some direction, in the mean over the recordings, the spread there is as many
    times as large, and `least` (n,) times in any direction: a rest that is slow in the earth's frame has a colour in
    the body's that follows the motion, and no spectrum shows it.
    """
    whole = [pooled(parts) for parts in several]
    size = _scale(pooled(whole).N)
    roots = [_root(one.N, size) for one in whole]
    u = [
        R @ inverse(one.N) @ (part.g - part.N @ one.c)
        for R, one, parts in zip(roots, whole, several, strict=True)
        for part in parts
    ]
    m = len(several[0])
    values, vectors = np.linalg.eigh(np.transpose(u) @ np.array(u) * m / (m - 1) / len(several))
    spreads = [vectors * np.maximum(values, floor) @ vectors.T for floor in least]
    return [CoefficientEstimate(one.N, one.g, R, spread) for one, R, spread in zip(whole, roots, spreads, strict=True)]


def pooled(several: Sequence[CoefficientEstimate]) -> CoefficientEstimate:
    """What all estimates together say of one coefficient."""
    return CoefficientEstimate(np.sum([one.N for one in several], axis=0), np.sum([one.g for one in several], axis=0))


def foretold(several: Sequence[CoefficientEstimate]) -> Array:
    """Coefficients (n, k) for each of n recordings that all the others together give."""
    rest = ([other for other in several if other is not one] for one in several)
    return np.array([pooled(others).c if others else np.zeros(len(several[0].g)) for others in rest])


def left_out_gains(several: Sequence[CoefficientEstimate]) -> Array:
    """Nats (n,) that the others' coefficients, as they are, explain in each recording under the stated errors."""
    return np.array([one.gain(c) for one, c in zip(several, foretold(several), strict=True)])


def size_over(one: CoefficientEstimate, c: Array) -> tuple[float, float] | None:
    """The factor a by which coefficients (k,) best explain an estimate, ``a = c^T g / c^T N c``, and its std.

    None where they explain nothing there whatever the factor.
    """
    information = float(c @ one.N @ c)
    return (float(c @ one.g) / information, (one.inflation(c) / information) ** 0.5) if information > 0 else None


def inverse(N: Array) -> Array:
    """Pseudo-inverse of an information matrix (k, k), whatever the units of its coefficients."""
    size = _scale(N)
    return np.asarray(np.linalg.pinv(N / np.outer(size, size), rcond=OPEN, hermitian=True) / np.outer(size, size))


def rank(N: Array) -> int:
    """How many combinations of coefficients an information matrix (k, k) determines."""
    size = _scale(N)
    values = np.linalg.eigvalsh(N / np.outer(size, size))
    return int(np.count_nonzero(values > OPEN * max(float(values.max(initial=0.0)), 1e-300))) if N.any() else 0


def _root(N: Array, size: Array) -> Array:
    """A root R (k, k) of an information matrix, ``R^T R = N``, symmetric for coefficients in units of 1 / size (k,)."""
    values, vectors = np.linalg.eigh(N / np.outer(size, size))
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)) @ vectors.T * size)


def _odds(Q: float, degrees: int, known: int | None) -> float:
    if degrees == 0:
        return 1.0
    return float(chi2.sf(Q, degrees) if known is None else f.sf(Q / degrees, degrees, known))


def _scale(N: Array) -> Array:
    """Root of the diagonal (k,), one where a coefficient has no information."""
    diagonal = np.diag(N)
    return np.asarray(np.sqrt(np.where(diagonal > 0, diagonal, 1.0)))
