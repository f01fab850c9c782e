"""Spectrum of a residual in bands that are evenly spaced in log frequency."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.special import gammaincc

from scenarios.arrays import Array

WINDOW_LINES = 35 / 18
"""Lines of a Hann-windowed spectrum over independent lines: the window correlates neighbours."""
LEAST_WHITE = 1e-4
"""Lower limit of the fitted white noise, over the noise of a sample: slow noise hides less."""


def hann(n: int) -> Array:
    """Return the Hann window (n, 1)."""
    return np.asarray(np.sin(np.pi * (np.arange(n) + 0.5) / n)[:, None] ** 2)


def even_bands(first: int, last: int, count: int) -> list[slice]:
    """Return bands of spectral lines from `first` to `last`, with at most `count` edges."""
    edges = np.unique(np.geomspace(first, last, count).astype(int))
    return [slice(a, b) for a, b in itertools.pairwise(edges)]


@dataclass(frozen=True)
class Bands:
    """Mean frequency f (m,), one-sided power density (m,) and gamma shape (m,) of bands of a spectrum."""

    f: Array
    power: Array
    shape: Array

    @classmethod
    def of(cls, residual: Array, interval_s: float, first_line: int, count: int) -> Bands:
        """Return at most `count` bands of a residual (n, q) from `first_line` on: Hann window, mean over outputs."""
        n, q = residual.shape
        window = hann(n)
        power = (np.abs(np.fft.rfft((residual - residual.mean(axis=0)) * window, axis=0)) ** 2).sum(axis=1)
        power *= 2 * interval_s / (window**2).sum() / q
        f = np.fft.rfftfreq(n, interval_s)
        band = even_bands(first_line, len(f) - 1, count)
        return cls(
            np.array([f[b].mean() for b in band]),
            np.array([power[b].mean() for b in band]),
            np.array([max(q, q * (b.stop - b.start) / WINDOW_LINES) for b in band], dtype=float),
        )

    def odds(self, ratio: Array) -> Array:
        """Return the probability (m,) that noise has at least `ratio` times the expected power in a band."""
        return np.asarray(gammaincc(self.shape, ratio / (1 / self.shape)))

    def fit(self, level: float, slow: Array) -> tuple[float, float, float]:
        """Return the greatest Whittle likelihood of ``S = w + s slow``, w and s; slow (m,) is zero for white noise.

        level : white noise of a sample; w is at least 1e-4 of `level`, because w = 0 leaves no scale.
        """

        def cost(x: Array) -> float:
            S = np.exp(x[0]) + np.exp(x[1]) * slow
            return float((self.shape * (np.log(S) + self.power / S)).sum())

        first = max(self.power[0] / max(slow[0], 1e-300), 1e-12) if slow.any() else 1.0
        start = np.log([level, first])
        found = minimize(cost, start, method="Nelder-Mead", options={"maxiter": 400, "xatol": 1e-3, "fatol": 1e-3})
        return -float(found.fun), max(float(np.exp(found.x[0])), LEAST_WHITE * level), float(np.exp(found.x[1]))
