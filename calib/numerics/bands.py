"""Frequency bands of evenly sampled series: the band of a manoeuvre, and filters without delay."""

from __future__ import annotations

import numpy as np

from scenarios.arrays import Array

NYQUIST_SHARES = (0.45, 0.9)
"""Highest lower and upper edge over the Nyquist frequency."""
AIRBORNE_HZ = (0.1, 0.9)
"""The band of airborne surveys, of manoeuvres of 5 to 10 s: above the Earth's own changes along a line, below the
vector sensor's noise [Leliak1961]."""
BELOW, ABOVE = 0.5, 6.0
"""Edges of a slower manoeuvre's band over the manoeuvre's frequency: a turn of 60 s of a submarine gives 0.008 to
0.1 Hz."""
ABOVE_FLOOR = 12.0
"""Power over the noise's from which a frequency counts as motion; white noise exceeds 12 in 6 of a million."""


def manoeuvre_band(values: Array, time_s: Array, noise_std: float) -> tuple[float, float]:
    """Band about the median frequency of the rate of change of values (n, k), Hz, within the band of airborne surveys.

    noise_std : white noise of a value, whose power is left out
    """
    from scipy.signal import periodogram  # half a second, which few methods need

    rate_hz = _rate_hz(time_s)
    frequency_hz, power = periodogram(values, rate_hz, window="hann", detrend="linear", axis=0)
    power = power.sum(axis=1)
    floor = 2.0 * noise_std**2 / rate_hz * values.shape[1]
    change = np.where(power > ABOVE_FLOOR * floor, frequency_hz**2 * power, 0.0)
    total = np.cumsum(change)
    middle_hz = float(frequency_hz[np.searchsorted(total, 0.5 * total[-1])]) if total[-1] > 0 else frequency_hz[1]
    return min(BELOW * middle_hz, AIRBORNE_HZ[0]), min(ABOVE * middle_hz, AIRBORNE_HZ[1])


def band(time_s: Array, band_hz: tuple[float, float]) -> tuple[float, float]:
    """The band's edges as fractions of the Nyquist frequency, where they exist at this sample rate."""
    nyquist_hz = 0.5 * _rate_hz(time_s)
    low, high = (min(edge / nyquist_hz, share) for edge, share in zip(band_hz, NYQUIST_SHARES, strict=True))
    return low, high


def band_passed(values: Array, time_s: Array, band_hz: tuple[float, float]) -> Array:
    """Values (n, k) through a second-order Butterworth band, forwards and backwards, without delay."""
    return _filtered(values, band(time_s, band_hz), "bandpass")


def low_passed(values: Array, time_s: Array, band_hz: tuple[float, float]) -> Array:
    """Values (n, k) below the upper edge of the band, or of the airborne band where higher, without delay."""
    upper_hz = max(band_hz[1], AIRBORNE_HZ[1])
    return _filtered(values, band(time_s, (band_hz[0], upper_hz))[1], "lowpass")


def _filtered(values: Array, edges: float | tuple[float, float], kind: str) -> Array:
    from scipy.signal import butter, sosfiltfilt

    return np.asarray(sosfiltfilt(butter(2, edges, kind, output="sos"), values, axis=0))


def _rate_hz(time_s: Array) -> float:
    return (len(time_s) - 1) / float(time_s[-1] - time_s[0])
