"""Errors of the sensor and its electronics, in forms that no candidate has."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import bessel, butter, freqs

from benchmarks.diagnosis.wide.courses import Course
from benchmarks.diagnosis.wide.forms import Complex, Form, answered, lagged, linear, way
from scenarios.arrays import Array
from sim.effects.kernels import kernel

REFERENCE_NT = 5e4


def bent(rng: np.random.Generator, course: Course, signal_nT: Array) -> Form:
    """A characteristic that saturates, bends in a fifth order, or has another slope beyond zero."""
    x = signal_nT / REFERENCE_NT
    size = way(rng)
    forms = (
        np.tanh(rng.uniform(0.6, 1.2) * x) - x,
        rng.normal() * x**2 + x**3 + rng.uniform(-0.7, 0.7) * x**5,
        np.sqrt(x**2 + rng.uniform(0.1, 0.3) ** 2) + rng.uniform(-0.5, 0.5) * x**3,
    )
    return linear(forms[int(rng.integers(3))] * size)


def warm_scale(rng: np.random.Generator, course: Course, signal_nT: Array) -> Form:
    """A sensitivity that follows a temperature felt late and not in a straight line."""
    return linear(signal_nT / REFERENCE_NT * _felt(rng, course)[:, None] * way(rng))


def warm_offset(rng: np.random.Generator, course: Course, signal_nT: Array) -> Form:
    """An offset that follows a temperature felt late and not in a straight line."""
    return linear(_felt(rng, course)[:, None] * way(rng))


def _felt(rng: np.random.Generator, course: Course) -> Array:
    """Temperature through two lags, or with a curve of second order, about its mean."""
    T = course.temperature_degC - course.temperature_degC.mean()
    if rng.uniform() < 0.5:
        return np.asarray(T + rng.uniform(-0.3, 0.3) * T**2 / max(float(np.abs(T).max()), 1e-9))
    return lagged(lagged(T[:, None], rng.uniform(2, 60)), rng.uniform(1, 15))[:, 0]


def plays(rng: np.random.Generator, course: Course, signal_nT: Array) -> Form:
    """A core with a memory: two to six plays of uneven widths, or a loop that bends as it turns round."""
    gain = np.abs(way(rng)) + 0.2
    if rng.uniform() < 0.4:
        return linear(-_bending(signal_nT, rng.uniform(800, 12_000)) * gain)
    widths = np.exp(rng.uniform(np.log(300), np.log(20_000), int(rng.integers(2, 7))))
    weights = rng.uniform(0.3, 1, len(widths))
    return linear(-sum(w * _stopped(signal_nT, r) for w, r in zip(weights, widths, strict=True)) * gain)


@kernel
def _stopped(signal: Array, width: float) -> Array:
    out = np.zeros_like(signal)
    for i in range(1, len(signal)):
        for j in range(3):
            out[i, j] = min(max(out[i - 1, j] + signal[i, j] - signal[i - 1, j], -width), width)
    return out


@kernel
def _bending(signal: Array, width: float) -> Array:
    """``dm = ds - |ds| m / r``: the distance to the loop's branch falls off exponentially."""
    out = np.zeros_like(signal)
    for i in range(1, len(signal)):
        for j in range(3):
            step = signal[i, j] - signal[i - 1, j]
            goal = width if step > 0 else -width
            out[i, j] = goal + (out[i - 1, j] - goal) * math.exp(-abs(step) / width)
    return out


def filtered(rng: np.random.Generator, course: Course, signal_nT: Array) -> Form:
    """A low-pass of order one to four, Butterworth or Bessel, or a moving average; its size is its delay."""
    kind, order = int(rng.integers(3)), int(rng.integers(1, 5))
    if kind == 2:
        return lambda size: answered(signal_nT, _average(size * 1e-3)) - signal_nT
    b, a = (butter if kind else bessel)(order, 1.0, analog=True)

    def form(size: float) -> Array:
        def response(f: Array) -> Complex:
            return np.asarray(freqs(b, a, 2 * np.pi * f * size * 1e-3)[1])

        return answered(signal_nT, response) - signal_nT

    return form


def _average(length_s: float) -> Callable[[Array], Complex]:
    """Response of the mean over a time that has passed."""
    return lambda f: np.asarray(np.sinc(f * length_s) * np.exp(-1j * np.pi * f * length_s))


def late(rng: np.random.Generator, course: Course, signal_nT: Array) -> Form:
    """Time stamps that come late: no whole sample, and by up to a quarter more or less in the run."""
    spline = CubicSpline(course.time_s, signal_nT, bc_type="natural")
    swing = np.sin(2 * np.pi * course.time_s / rng.uniform(60, 2000) + rng.uniform(0, 6))
    delay = 1e-3 * (1 + rng.uniform(0, 0.25) * swing)
    return lambda size: spline(np.maximum(course.time_s - size * delay, 0.0)) - signal_nT


def jump(rng: np.random.Generator, course: Course, signal_nT: Array) -> Form:
    """An offset that changes within seconds, or in a large and a small step."""
    at_s = rng.uniform(0.15, 0.85) * course.duration_s
    edge = np.clip((course.time_s - at_s) / rng.uniform(0.02, 3.0), 0.0, 1.0)
    again = course.time_s > at_s + rng.uniform(0.5, 6.0)
    return linear((edge + rng.uniform(0, 0.15) * again)[:, None] * way(rng))
