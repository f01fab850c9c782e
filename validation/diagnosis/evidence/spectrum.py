"""The spectrum of a residual in bands, and the slow random disturbance that fits it best."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.stats import gamma

from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.state import Array
from validation.diagnosis.evidence.steps import Density
from validation.diagnosis.policy import Policy

WINDOW_LINES = 35 / 18
"""By how much a Hann window correlates neighbouring lines: lines over independent ones."""
LEAST_WHITE = 1e-4
"""White noise over that of a sample, below which it does not show beside a slow noise and is taken for so much."""


@dataclass(frozen=True)
class Bands:
    """Mean frequency f (m,), one-sided power density (m,) and gamma shape (m,) of bands of a spectrum."""

    f: Array
    power: Array
    shape: Array

    @classmethod
    def of(cls, residual: Array, interval_s: float, policy: Policy) -> Bands:
        """Bands evenly spaced in log f of a residual (n, q), mean over outputs, under a Hann window."""
        n, q = residual.shape
        window = np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 2
        varying = residual - residual.mean(axis=0)
        power = (np.abs(np.fft.rfft(varying * window[:, None], axis=0)) ** 2).sum(axis=1)
        power *= 2 * interval_s / (window**2).sum() / q
        f = np.fft.rfftfreq(n, interval_s)
        edges = np.unique(np.geomspace(policy.first_line, len(f) - 1, policy.bands).astype(int))
        band = [slice(a, b) for a, b in itertools.pairwise(edges)]
        return cls(
            np.array([f[b].mean() for b in band]),
            np.array([power[b].mean() for b in band]),
            np.array([max(q, q * (b.stop - b.start) / WINDOW_LINES) for b in band], dtype=float),
        )

    def odds(self, ratio: Array) -> Array:
        """Probability (m,) that noise of the expected spectrum has so many times its power in a band, or more."""
        return np.asarray(gamma.sf(ratio, self.shape, scale=1 / self.shape))

    def fit(self, level: float, slow: Array) -> tuple[float, float, float]:
        """Greatest Whittle likelihood of ``S = w + s slow`` (slow (m,), zero: white alone), and w and s there.

        level : white noise of a sample, of which w is a ten-thousandth at least: without any a likelihood has no scale.
        """

        def cost(x: Array) -> float:
            S = np.exp(x[0]) + np.exp(x[1]) * slow
            return float((self.shape * (np.log(S) + self.power / S)).sum())

        first = max(self.power[0] / max(slow[0], 1e-300), 1e-12) if slow.any() else 1.0
        start = np.log([level, first])
        found = minimize(cost, start, method="Nelder-Mead", options={"maxiter": 400, "xatol": 1e-3, "fatol": 1e-3})
        return -float(found.fun), max(float(np.exp(found.x[0])), LEAST_WHITE * level), float(np.exp(found.x[1]))


@dataclass(frozen=True)
class SlowSpectrum:
    """The best slow noise of the library in a spectrum: ``S(f) = level + size shape(f)``, and those as good."""

    bands: Bands
    effect: type[Effect]
    shape: Density
    others: tuple[str, ...]
    level: float
    size: float

    @classmethod
    def of(cls, residual: Array, interval_s: float, policy: Policy) -> SlowSpectrum:
        """The best of every effect that has a spectrum, for a residual (n, q) in units of the noise."""
        bands = Bands.of(residual, interval_s, policy)
        shapes = {effect: shape for effect in EFFECTS if (shape := effect.clues.spectrum) is not None}
        fits = {effect: bands.fit(2 * interval_s, shape(bands.f)) for effect, shape in shapes.items()}
        best = max(fits, key=lambda effect: fits[effect][0])
        others = tuple(e.name for e in fits if e is not best and fits[best][0] - fits[e][0] < policy.apart)
        return cls(bands, best, shapes[best], others, *fits[best][1:])

    def density(self, f: Array) -> Array:
        """S(f)."""
        return np.asarray(self.level + self.size * self.shape(f))

    def agrees(self, policy: Policy) -> bool:
        """Whether no band is far from S."""
        ratio = self.bands.power / self.density(self.bands.f)
        odds = self.bands.odds(np.abs(ratio - 1) + 1)
        return bool(odds.min() > policy.band_alarm / len(odds))

    def lines_above_white(self, policy: Policy) -> float:
        """At how many frequencies the slow noise stands out of the white one."""
        return float(self.bands.shape[self.density(self.bands.f) > policy.stands_out * self.level].sum())
