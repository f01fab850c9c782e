"""Slow-noise effect of the library that fits the spectrum of a residual best."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from diagnosis.library.parameter_search import between_neighbours
from diagnosis.policy import Policy
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.effects.base import Effect
from validation.signals.bands import Bands

Fit = tuple[float, float, float]
"""Likelihood, white level and size of the slow noise."""


@dataclass(frozen=True)
class SlowSpectrum:
    """The best slow noise ``S(f) = level + size shape(f)`` of the library, and the names of equally good effects.

    listed : the effect's listed parameters, such as a correlation time, by name.
    """

    bands: Bands
    effect: type[Effect]
    listed: dict[str, float]
    interval_s: float
    others: tuple[str, ...]
    level: float
    size: float

    @classmethod
    def of(cls, residual: Array, interval_s: float, policy: Policy) -> SlowSpectrum:
        """Fit every effect with a spectrum to a residual (n, q) in units of the noise, and select the best.

        Of equally good effects the one without a listed parameter, which has a number less.
        """
        bands = Bands.of(residual, interval_s, policy.first_line, policy.bands)
        fits = {effect: _best(effect, bands, interval_s) for effect in EFFECTS if effect.traits.spectrum is not None}
        most = max(score for _, (score, *_) in fits.values())
        near = [effect for effect in fits if most - fits[effect][1][0] < policy.apart]
        best = min(near, key=lambda effect: (len(effect.search), -fits[effect][1][0]))
        others = tuple(effect.name for effect in near if effect is not best)
        listed, (_, level, size) = fits[best]
        return cls(bands, best, listed, interval_s, others, level, size)

    def shape(self, f: Array) -> Array:
        """Density of the effect at unit level, at frequencies f (m,)."""
        return _shape(self.effect, f, self.interval_s, self.listed)

    def density(self, f: Array) -> Array:
        """S(f) at frequencies f (m,)."""
        return np.asarray(self.level + self.size * self.shape(f))

    def agrees(self, policy: Policy) -> bool:
        """Whether no band deviates significantly from S."""
        ratio = self.bands.power / self.density(self.bands.f)
        odds = self.bands.odds(np.abs(ratio - 1) + 1)
        return bool(odds.min() > policy.test_alarm / len(odds))

    def lines_above_white(self, policy: Policy) -> float:
        """Number of frequencies at which the slow noise exceeds the white noise."""
        return float(self.bands.shape[self.density(self.bands.f) > policy.clearly_larger * self.level].sum())


def _shape(effect: type[Effect], f: Array, interval_s: float, listed: dict[str, float]) -> Array:
    assert effect.traits.spectrum is not None
    return effect.traits.spectrum(f, interval_s, **listed)


def _best(effect: type[Effect], bands: Bands, interval_s: float) -> tuple[dict[str, float], Fit]:
    """The listed parameters of largest likelihood, refined between their neighbours, and the fit."""

    def fit(listed: dict[str, float]) -> Fit:
        return bands.fit(2 * interval_s, _shape(effect, bands.f, interval_s, listed))

    if not effect.search:
        return {}, fit({})
    ((name, values),) = effect.search.items()
    first = max(values, key=lambda value: fit({name: value})[0])
    first = between_neighbours(values, first, lambda x: -fit({name: x})[0], within=0.02)
    return {name: first}, fit({name: first})
