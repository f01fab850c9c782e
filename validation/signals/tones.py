"""Lines in the spectrum of a residual, and aliases of the mains."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.special import gammaincc

from scenarios.arrays import Array
from sim.state import SPARSEST
from validation.policy import POLICY
from validation.signals.intervals import usual_interval

MAINS_HZ = (50.0, 60.0)
HARMONICS = (1, 2, 3)
NEIGHBOURHOOD = 201
"""Bins whose median is the background of the middle bin."""
NARROWER = (65, 21, 7)
"""Numbers of bins near zero frequency, where noise may rise steeply."""
MOST_TONES = 20
"""Tones that are returned at most."""


@dataclass(frozen=True)
class Spectrum:
    """Hann-windowed periodogram: `density` (m, k) in unit^2/Hz one-sided, its local `background` (m, k)."""

    frequency_hz: Array
    density: Array
    background: Array


@dataclass(frozen=True)
class Tone:
    """Spectral line: amplitude (k,) of each axis, height over the background, peaks as high expected by chance."""

    frequency_hz: float
    amplitude: Array
    ratio: float
    false_alarm: float


def spectrum(time_s: Array, residual: Array) -> Spectrum | None:
    """Return the spectrum of a residual (n, k) at times (n,) on an even grid with zeros in gaps; None if too short."""
    grid = _on_grid(time_s, residual)
    if grid is None:
        return None
    values, present, interval_s = grid
    window = np.hanning(len(values) + 2)[1:-1, None]
    power = np.abs(np.fft.rfft(values * window, axis=0)) ** 2
    density = 2 * interval_s * power / float((window[present] ** 2).sum())
    return Spectrum(np.asarray(np.fft.rfftfreq(len(values), interval_s), np.float64), density, _background(density))


def _background(density: Array) -> Array:
    """Return the mean density (m, k) from running medians of NEIGHBOURHOOD bins, and of fewer near zero frequency.

    A median of exponential variables is ln 2 times the mean.
    """
    background = np.zeros_like(density)
    for size in (NEIGHBOURHOOD, *NARROWER):
        near = density if size == NEIGHBOURHOOD else density[: 2 * size]
        filtered = (median_filter(column, min(size, len(near)), mode="reflect") for column in near.T.copy())
        part = np.column_stack(list(filtered)) / np.log(2)
        background[: len(part)] = np.maximum(background[: len(part)], part)
    return background


def _on_grid(time_s: Array, residual: Array) -> tuple[Array, NDArray[np.bool_], float] | None:
    """Return values less their mean on an even grid, a mask of filled places, and the interval in s."""
    if len(time_s) < POLICY.least_spectrum:
        return None
    interval_s = usual_interval(time_s)
    if not interval_s > 0:
        return None
    place = (time_s - time_s[0]) / interval_s
    if place[-1] > SPARSEST * len(time_s):
        return None
    if np.all(np.diff(time_s) <= POLICY.gap * interval_s):
        interval_s = float(time_s[-1] - time_s[0]) / (len(time_s) - 1)
        index = np.arange(len(time_s))
    else:
        index = np.rint(place).astype(np.intp)
    values = np.zeros((int(index[-1]) + 1, residual.shape[1]))
    present = np.zeros(len(values), np.bool_)
    sound = np.isfinite(residual).all(axis=1)
    if np.count_nonzero(sound) < POLICY.least_spectrum:
        return None
    values[index[sound]] = residual[sound] - residual[sound].mean(axis=0)
    present[index[sound]] = True
    return values, present, interval_s


def tones(time_s: Array, residual: Array, *, false_alarm: float = POLICY.tone_alarm) -> list[Tone]:
    """Return lines in the spectrum of a residual (n, k), strongest first.

    Periodograms of the axes are divided by the local background and summed: exponential variables for noise of any
    colour that is smooth over NEIGHBOURHOOD bins. Fewer than `false_alarm` peaks as high are expected by chance.
    """
    found = spectrum(time_s, residual)
    if found is None:
        return []
    usable = np.all(found.background > 0, axis=1)
    usable[:4] = usable[-3:] = False
    axes = residual.shape[1]
    height = np.zeros(len(usable))
    height[usable] = (found.density[usable] / found.background[usable]).sum(axis=1)
    chance = np.count_nonzero(usable) * gammaincc(axes, height)
    peaks = np.flatnonzero(usable & (chance < false_alarm) & _highest(height))
    peaks = peaks[np.argsort(height[peaks])[::-1][:MOST_TONES]]
    return [_tone(time_s, residual, found, height, int(peak), float(chance[peak])) for peak in peaks]


def _highest(height: Array, reach: int = 3) -> NDArray[np.bool_]:
    """Return a mask of peaks: bins that no bin within `reach` exceeds."""
    around = np.pad(height, reach)
    best = np.max([around[k : k + len(height)] for k in range(2 * reach + 1)], axis=0)
    return np.asarray(height >= best)


def _tone(time_s: Array, residual: Array, found: Spectrum, height: Array, peak: int, chance: float) -> Tone:
    """Return a tone: frequency from the three bins of the main lobe, amplitudes by least squares."""
    power = found.density.sum(axis=1)
    left, middle, right = np.sqrt(power[peak - 1 : peak + 2])
    shift = (2 * max(left, right) - middle) / (middle + max(left, right)) * (1 if right > left else -1)
    bin_hz = float(found.frequency_hz[1])
    frequency_hz = (peak + float(np.clip(shift, -0.5, 0.5))) * bin_hz
    angle = 2 * np.pi * frequency_hz * (time_s - time_s[0])
    window = np.hanning(len(time_s) + 2)[1:-1, None]
    columns = np.column_stack([np.cos(angle), np.sin(angle), np.ones(len(angle))])
    sound = np.isfinite(residual).all(axis=1)
    fit = np.linalg.lstsq((columns * window)[sound], (residual * window)[sound], rcond=None)[0]
    return Tone(frequency_hz, np.asarray(np.hypot(fit[0], fit[1])), float(height[peak]), chance)


def alias_hz(frequency_hz: float, rate_hz: float) -> float:
    """Return the alias of a frequency at a sampling rate: |f - rate round(f / rate)|."""
    return abs(frequency_hz - rate_hz * round(frequency_hz / rate_hz))


def mains_aliases(rate_hz: float) -> dict[str, float]:
    """Return aliases in Hz of 50 Hz, 60 Hz and harmonics at a sampling rate, by name as "2 x 50 Hz"."""
    names = {f"{k} x {mains:g} Hz" if k > 1 else f"{mains:g} Hz": k * mains for mains in MAINS_HZ for k in HARMONICS}
    return {name: alias_hz(frequency, rate_hz) for name, frequency in names.items()}


def mains_named(tone: Tone, rate_hz: float, resolution_hz: float) -> tuple[str, ...]:
    """Return names of the mains lines that match a tone within the mains' drift and the resolution."""
    names = []
    for name, alias in mains_aliases(rate_hz).items():
        nominal = float(np.prod([float(part) for part in name.removesuffix(" Hz").split(" x ")]))
        width_hz = resolution_hz + POLICY.mains_drift * nominal
        if width_hz < POLICY.mains_width * rate_hz and abs(tone.frequency_hz - alias) < width_hz:
            names.append(name)
    return tuple(names)
