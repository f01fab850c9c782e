"""What is tried on top of offset and matrix: eddy currents, and a temperature against any other slow signal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from calib.numerics.rates import body_rate
from recordings import Recording
from scenarios.arrays import Array
from validation.cross_validation.legs import LegPartition
from validation.cross_validation.models import Model, with_eddy, with_warmth
from validation.cross_validation.paired_legs import ModelPair, Unseen

Add = Callable[[Model], Model]
SURROGATES = 39
"""Signals of the temperature's spectrum: it is one of forty, so that a drift passes for it in 2.5 % of recordings."""
DRIFT = "other slow signals do too: it may be a drift"
VARIES_DEGC = 1e-6
"""A temperature whose rms change is less tells nothing."""


@dataclass(frozen=True)
class Extra:
    """What makes a model richer, and others of its kind that are no cause: it must gain more than any of them."""

    add: Add
    rivals: tuple[Add, ...] = ()

    def pair(self, base: Unseen, legs: LegPartition, strength_nT: float) -> ModelPair:
        """A model without and with it on the same legs."""
        found = ModelPair(base, Unseen.of(self.add(base.model), legs, strength_nT))
        if found.verdict != "worth_it":
            return found
        others = (Unseen.of(rival(base.model), legs, strength_nT) for rival in self.rivals)
        same = any(one.typical_nT <= found.richer.typical_nT for one in others)
        return ModelPair(base, found.richer, DRIFT if same else "")


def extras(recording: Recording) -> tuple[Extra, ...]:
    """Eddy currents where the body rate is known, an offset by the temperature where one is recorded and changes."""
    rate_rad_s, warmth = body_rate(recording), recording.temperature_degC
    found = [] if rate_rad_s is None else [Extra(partial(with_eddy, rate_rad_s=rate_rad_s))]
    if warmth is not None and warmth.std() > VARIES_DEGC:
        rivals = tuple(partial(with_warmth, warmth=other) for other in surrogates(warmth))
        found.append(Extra(partial(with_warmth, warmth=warmth), rivals))
    return tuple(found)


def surrogates(values: Array, count: int = SURROGATES) -> Array:
    """Signals (count, n) with the spectrum of values (n,), which are taken as going back the way they came."""
    rng = np.random.default_rng(0)
    size = np.abs(np.fft.rfft(np.concatenate([values, values[::-1]]) - values.mean()))
    phases = np.exp(2j * np.pi * rng.random((count, len(size))))
    return np.asarray(np.fft.irfft(size * phases, 2 * len(values), axis=1)[:, : len(values)])
