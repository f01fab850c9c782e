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
    """Mean frequency f (m,), number of lines (m,) and one-sided power density (q, m) of each output in bands.

    samples, interval_s : number of samples, and the time between two.
    """

    f: Array
    lines: Array
    density: Array
    samples: int
    interval_s: float

    @classmethod
    def of(cls, residual: Array, interval_s: float, first_line: int, count: int) -> Bands:
        """Return at most `count` bands of a residual (n, q) from `first_line` on, under a Hann window."""
        window = hann(len(residual))
        power = np.abs(np.fft.rfft((residual - residual.mean(axis=0)) * window, axis=0)) ** 2
        power *= 2 * interval_s / (window**2).sum()
        band, f = even_bands(first_line, len(power), count), np.fft.rfftfreq(len(residual), interval_s)
        lines = np.array([b.stop - b.start for b in band], dtype=float)
        density = np.stack([power[b].mean(axis=0) for b in band], axis=1)
        return cls(np.array([f[b].mean() for b in band]), lines, density, len(residual), interval_s)

    @property
    def power(self) -> Array:
        """Density (m,), mean over the outputs."""
        return np.asarray(self.density.mean(axis=0))

    @property
    def shape(self) -> Array:
        """Gamma shape (m,) of the mean density."""
        return np.asarray(len(self.density) * np.maximum(1.0, self.lines / WINDOW_LINES))

    def chance(self, ratio: Array) -> float:
        """Return the probability that noise has at least `ratio` (m,) times the expected power in any of the bands."""
        return float(gammaincc(self.shape, ratio * self.shape).min()) * len(self.f)

    def fit(self, slow: Array) -> tuple[float, float, float]:
        """Return the greatest Whittle likelihood of ``S = w + s slow``, w and s; slow (m,) is zero for white noise.

        w is at least 1e-4 of white noise of variance one, because w = 0 leaves no scale.
        """
        level = 2 * self.interval_s

        def cost(x: Array) -> float:
            S = np.exp(x[0]) + np.exp(x[1]) * slow
            return float((self.shape * (np.log(S) + self.power / S)).sum())

        first = max(self.power[0] / max(slow[0], 1e-300), 1e-12) if slow.any() else 1.0
        start = np.log([level, first])
        found = minimize(cost, start, method="Nelder-Mead", options={"maxiter": 400, "xatol": 1e-3, "fatol": 1e-3})
        return -float(found.fun), max(float(np.exp(found.x[0])), LEAST_WHITE * level), float(np.exp(found.x[1]))
