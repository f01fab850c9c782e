"""One effect's coefficients in several recordings: pooled, held against each other, and foretold by the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2, f

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


def with_scatter(several: Sequence[Sequence[Estimate]], least: Sequence[float]) -> list[Estimate]:
    """Estimates of n recordings from their m parts each, with the error that the parts' scores show.

    Were the stated error right, the squares of ``u_b = N^-1/2 (g_b - N_b c) sqrt(m / (m - 1))`` summed over the parts b
    would be I. Where they are more in some direction, in the mean over the recordings, the covariance there is as many
    times as large, and `least` (n,) times in any direction: a rest that is slow in the earth's frame has a colour in
    the body's that follows the motion, and no spectrum shows it.
    """
    whole = [_common(parts) for parts in several]
    size = _size(whole)
    roots = [_root(one.N / np.outer(size, size)) for one in whole]
    u = [
        root @ ((part.g - part.N @ one.c) / size)
        for root, one, parts in zip(roots, whole, several, strict=True)
        for part in parts
    ]
    m = len(several[0])
    values, vectors = np.linalg.eigh(np.transpose(u) @ np.array(u) * m / (m - 1) / len(several))
    found = []
    for one, root, floor in zip(whole, roots, least, strict=True):
        spread = vectors * np.maximum(values, floor) @ vectors.T
        W = inverse(root @ spread @ root) * np.outer(size, size)
        found.append(Estimate(W, W @ one.c))
    return found


def _root(N: Array) -> Array:
    """``N^-1/2`` (k, k), zero along what is open."""
    values, vectors = np.linalg.eigh(N)
    there = values > OPEN * max(float(values.max()), 1e-300)
    return np.asarray(vectors[:, there] * values[there] ** -0.5 @ vectors[:, there].T)


def agreement(several: Sequence[Estimate], form: float, known: int | None = None) -> Agreement:
    """The common coefficient of estimates and the chi-square of their differences from it.

    ``Q = sum_i c_i^T W_i c_i - c^T (sum_i W_i) c``, chi-square of ``sum_i rank N_i - rank sum_i N_i`` degrees.
    form : share of the effect by which its form is in error on one motion or another; it widens every W_i by
    ``F = form^2 (c^T N c / k) N^+`` with N the mean information, an error of that size in any direction. The common
    coefficient and its covariance are without it; the covariance grows with what the recordings differ beyond their
    own errors. known : degrees of freedom that these errors are known with; then Q over its degrees is an F.
    """
    size = _size(several)
    scaled = [Estimate(one.N / np.outer(size, size), one.g / size) for one in several]
    common = _common(scaled)
    mean = np.mean([one.N for one in scaled], axis=0)
    F = form**2 * float(common.c @ mean @ common.c) / len(size) * inverse(mean)
    degrees = sum(rank(one.N) for one in scaled) - rank(common.N)
    Q = _differences([one.blurred(F) for one in scaled])
    p = _odds(Q, degrees, known)
    scatter = max(1.0, _differences(scaled) / degrees) if degrees > 0 else 1.0
    return Agreement(common.c / size, scatter * common.covariance / np.outer(size, size), Q, degrees, p)


def _odds(Q: float, degrees: int, known: int | None) -> float:
    if degrees == 0:
        return 1.0
    return float(chi2.sf(Q, degrees) if known is None else f.sf(Q / degrees, degrees, known))


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
