"""Flicker noise for tests, made by another way than the simulator's."""

from __future__ import annotations

import numpy as np


def flicker(n: int, rng: np.random.Generator, longer: int = 64) -> np.ndarray:
    """Noise (n, 3) of one-sided density 1 / f per Hz, at any rate, cut from a record `longer` times as long."""
    whole = longer * n
    spectrum = np.fft.rfft(rng.standard_normal((whole, 3)), axis=0)
    spectrum[1:] /= np.sqrt(2.0 * np.fft.rfftfreq(whole)[1:, None])
    spectrum[0] = 0.0
    return np.asarray(np.fft.irfft(spectrum, whole, axis=0)[:n])
