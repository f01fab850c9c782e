"""Slow-noise effect of the library that fits the spectrum of a residual best."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from diagnosis.evidence.block_steps import Density
from diagnosis.policy import Policy
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.effects.base import Effect
from validation.signals.bands import Bands


@dataclass(frozen=True)
class SlowSpectrum:
    """The best slow noise ``S(f) = level + size shape(f)`` of the library, and the names of equally good effects."""

    bands: Bands
    effect: type[Effect]
    shape: Density
    others: tuple[str, ...]
    level: float
    size: float

    @classmethod
    def of(cls, residual: Array, interval_s: float, policy: Policy) -> SlowSpectrum:
        """Fit every effect with a spectrum to a residual (n, q) in units of the noise, and select the best."""
        bands = Bands.of(residual, interval_s, policy.first_line, policy.bands)
        shapes = {effect: shape for effect in EFFECTS if (shape := effect.traits.spectrum) is not None}
        fits = {effect: bands.fit(2 * interval_s, shape(bands.f)) for effect, shape in shapes.items()}
        best = max(fits, key=lambda effect: fits[effect][0])
        others = tuple(e.name for e in fits if e is not best and fits[best][0] - fits[e][0] < policy.apart)
        return cls(bands, best, shapes[best], others, *fits[best][1:])

    def density(self, f: Array) -> Array:
        """S(f) at frequencies f (m,)."""
        return np.asarray(self.level + self.size * self.shape(f))

    def agrees(self, policy: Policy) -> bool:
        """Whether no band deviates significantly from S."""
        ratio = self.bands.power / self.density(self.bands.f)
        odds = self.bands.odds(np.abs(ratio - 1) + 1)
        return bool(odds.min() > policy.band_alarm / len(odds))

    def lines_above_white(self, policy: Policy) -> float:
        """Number of frequencies at which the slow noise exceeds the white noise."""
        return float(self.bands.shape[self.density(self.bands.f) > policy.stands_out * self.level].sum())
