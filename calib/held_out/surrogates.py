"""Signals with the spectrum of a given one: what any slow signal would explain."""

from __future__ import annotations

import numpy as np

from scenarios.arrays import Array

SURROGATES = 39
"""Surrogates with a signal's spectrum; a drift passes for the signal in 1 of 40 recordings, 2.5 %."""
DRIFT = "so do other slow signals: the cause may be a drift"
"""The doubt about a signal that a surrogate equals."""


def surrogates(values: Array, count: int = SURROGATES) -> Array:
    """Return signals (count, n) with the spectrum of values (n,), continued by the reversed values."""
    rng = np.random.default_rng(0)
    size = np.abs(np.fft.rfft(np.concatenate([values, values[::-1]]) - values.mean()))
    phases = np.exp(2j * np.pi * rng.random((count, len(size))))
    return np.asarray(np.fft.irfft(size * phases, 2 * len(values), axis=1)[:, : len(values)])
