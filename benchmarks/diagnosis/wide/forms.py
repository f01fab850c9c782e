"""A hidden effect as a form: a function of its size, made of the course and of the signal that it meets."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from benchmarks.diagnosis.wide.courses import STEP_S, Course
from scenarios.arrays import Array

Complex = NDArray[np.complex128]
Form = Callable[[float], Array]
"""Size -> what is added to the signal (n, 3) in nT."""
Family = Callable[[np.random.Generator, Course, Array], Form]
"""(rng, course, signal (n, 3) at the effect's place in the chain) -> a form."""


def linear(added: Array) -> Form:
    """A form whose size multiplies it."""
    return lambda size: size * added


def way(rng: np.random.Generator) -> Array:
    """A direction (3,) with all axes taking part."""
    v = rng.normal(size=3) + 0.3 * rng.choice([-1, 1], 3)
    return np.asarray(v / np.linalg.norm(v))


def answered(signal: Array, response: Callable[[Array], Complex]) -> Array:
    """A continuous signal (n, q) through an instrument with frequency response H(f), mirrored beyond its ends."""
    n = len(signal)
    before, after = 2 * signal[0] - signal[n - 1 : 0 : -1], 2 * signal[-1] - signal[-2::-1]
    longer = np.concatenate([before[-n // 4 :], signal, after[: n // 4]])
    first, last = longer[0], longer[-1]
    ramp = first + np.linspace(0, 1, len(longer))[:, None] * (last - first)
    spectrum = np.fft.rfft(longer - ramp, axis=0)
    f = np.asarray(np.fft.rfftfreq(len(longer), STEP_S), dtype=np.float64)
    late_s = -np.angle(response(np.array([1e-5]))[0]) / (2 * np.pi * 1e-5)
    out = np.fft.irfft(spectrum * response(f)[:, None], len(longer), axis=0)
    out += ramp - late_s * (last - first) / ((len(longer) - 1) * STEP_S)
    start = len(longer[: len(before[-n // 4 :])])
    return np.asarray(out[start : start + n])


def lagged(signal: Array, lag_s: float) -> Array:
    """A signal (n, q) behind a first-order lag."""
    return answered(signal, lambda f: np.asarray(1 / (1 + 2j * np.pi * f * lag_s), dtype=np.complex128))
