"""Temperature against any other slow signal: a drift can look like whatever changes slowly."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.dataset import Recording
from validation.worth.legs import Legs
from validation.worth.models import with_warmth
from validation.worth.paired import Pair, Unseen

Array = NDArray[np.float64]
SURROGATES = 39
"""Signals of the temperature's spectrum: it is one of forty, so that a drift passes for it in 2.5 % of recordings."""
DRIFT = "other slow signals do too: it may be a drift"
VARIES_DEGC = 1e-6
"""A temperature whose rms change is less tells nothing."""


def with_temperature(base: Unseen, recording: Recording, legs: Legs, strength_nT: float) -> Pair | None:
    """An offset that grows with the temperature; None where it is not recorded or does not change.

    Doubtful where it gains no more than signals of its own spectrum and random phases do.
    """
    warmth = recording.temperature_degC
    if warmth is None or not warmth.std() > VARIES_DEGC:
        return None
    found = Pair(base, Unseen.of(with_warmth(base.model, warmth), legs, strength_nT))
    if found.verdict != "worth_it":
        return found
    others = (Unseen.of(with_warmth(base.model, other), legs, strength_nT) for other in surrogates(warmth))
    same = any(one.typical_nT <= found.richer.typical_nT for one in others)
    return Pair(base, found.richer, DRIFT if same else "")


def surrogates(values: Array, count: int = SURROGATES) -> Array:
    """Signals (count, n) with the spectrum of values (n,), which are taken as going back the way they came."""
    rng = np.random.default_rng(0)
    size = np.abs(np.fft.rfft(np.concatenate([values, values[::-1]]) - values.mean()))
    phases = np.exp(2j * np.pi * rng.random((count, len(size))))
    return np.asarray(np.fft.irfft(size * phases, 2 * len(values), axis=1)[:, : len(values)])
