"""Extensions of offset and matrix: eddy currents, and a temperature, compared with other slow signals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from calib.numerics.rates import body_rate
from recordings import Recording
from scenarios.arrays import Array
from validation.cross_validation.legs import LegPartition
from validation.cross_validation.models import Model, with_eddy, with_temperature
from validation.cross_validation.paired_legs import HeldOutErrors, ModelPair

Add = Callable[[Model], Model]
SURROGATES = 39
"""Surrogates with the temperature's spectrum; a drift passes for the temperature in 1 of 40 recordings, 2.5 %."""
DRIFT = "so do other slow signals: the cause may be a drift"
VARIES_DEGC = 1e-6
"""Rms change below which a temperature is not tried."""


@dataclass(frozen=True)
class Extension:
    """Extension of a model, with surrogate extensions that must all gain less."""

    add: Add
    rivals: tuple[Add, ...] = ()

    def pair(self, base: HeldOutErrors, legs: LegPartition, strength_nT: float) -> ModelPair:
        """Return the pair of models without and with the extension, on equal legs."""
        found = ModelPair(base, HeldOutErrors.of(self.add(base.model), legs, strength_nT))
        if found.verdict != "worth_it":
            return found
        others = (HeldOutErrors.of(rival(base.model), legs, strength_nT) for rival in self.rivals)
        same = any(one.typical_nT <= found.richer.typical_nT for one in others)
        return ModelPair(base, found.richer, DRIFT if same else "")


def extensions(recording: Recording) -> tuple[Extension, ...]:
    """Return eddy currents for a known body rate, and an offset by temperature for a recorded temperature."""
    rate_rad_s, temperature_degC = body_rate(recording), recording.temperature_degC
    found = [] if rate_rad_s is None else [Extension(partial(with_eddy, rate_rad_s=rate_rad_s))]
    if temperature_degC is not None and temperature_degC.std() > VARIES_DEGC:
        rivals = tuple(partial(with_temperature, temperature_degC=other) for other in surrogates(temperature_degC))
        found.append(Extension(partial(with_temperature, temperature_degC=temperature_degC), rivals))
    return tuple(found)


def surrogates(values: Array, count: int = SURROGATES) -> Array:
    """Return signals (count, n) with the spectrum of values (n,), continued by the reversed values."""
    rng = np.random.default_rng(0)
    size = np.abs(np.fft.rfft(np.concatenate([values, values[::-1]]) - values.mean()))
    phases = np.exp(2j * np.pi * rng.random((count, len(size))))
    return np.asarray(np.fft.irfft(size * phases, 2 * len(values), axis=1)[:, : len(values)])
