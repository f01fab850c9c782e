"""Fields of the vehicle, in forms that no candidate has."""

from __future__ import annotations

import numpy as np

from benchmarks.diagnosis.wide.courses import STEP_S, Course
from benchmarks.diagnosis.wide.forms import Form, lagged, linear, way
from scenarios.arrays import Array


def settling_iron(rng: np.random.Generator, course: Course, signal_nT: Array) -> Form:
    """A hard iron that drifts: it settles, creeps with a root of time, or changes its pace halfway."""
    x = course.time_s / course.duration_s
    kink = rng.uniform(0.3, 0.7)
    courses = (
        1 - np.exp(-x / rng.uniform(0.7, 3.0)),
        x ** rng.uniform(0.7, 1.3),
        np.where(x < kink, x, kink + rng.uniform(0.6, 1.5) * (x - kink)),
    )
    return linear(courses[int(rng.integers(3))][:, None] * way(rng))


def eddies(rng: np.random.Generator, course: Course, signal_nT: Array) -> Form:
    """Eddy currents of an uneven hull: an asymmetrical matrix, one or two time constants."""
    matrix = np.eye(3) * rng.uniform(0.3, 1) + 0.5 * rng.normal(size=(3, 3))
    rate = np.gradient(course.field_nT, STEP_S, axis=0) @ matrix.T
    first, second = lagged(rate, rng.uniform(0.02, 0.3)), lagged(rate, rng.uniform(0.3, 1.0))
    return linear(first + (rng.uniform(0.1, 0.4) * second if rng.uniform() < 0.5 else 0.0))


def thrusters(rng: np.random.Generator, course: Course, signal_nT: Array) -> Form:
    """One motor or all: with a dead zone, or a part that goes with the square; another one adds up to a third."""
    count = course.current_A.shape[1]
    chosen = int(rng.integers(count))
    law = (_dead, _squared, _plain)[int(rng.integers(3))]
    if rng.uniform() < 0.3:
        return linear(law(rng, course.current_A.sum(axis=1))[:, None] * way(rng))
    main = law(rng, course.current_A[:, chosen])[:, None] * way(rng)
    other = course.current_A[:, (chosen + 1 + int(rng.integers(count - 1))) % count]
    return linear(main + (rng.uniform(0.05, 0.35) * other[:, None] * way(rng) if rng.uniform() < 0.5 else 0.0))


def _dead(rng: np.random.Generator, current_A: Array) -> Array:
    zone = rng.uniform(0.1, 0.4) * np.abs(current_A).mean()
    return np.asarray(np.sign(current_A) * np.maximum(np.abs(current_A) - zone, 0.0))


def _squared(rng: np.random.Generator, current_A: Array) -> Array:
    return np.asarray(current_A * (1 + rng.uniform(0.1, 0.6) * np.abs(current_A) / np.abs(current_A).max()))


def _plain(rng: np.random.Generator, current_A: Array) -> Array:
    return lagged(current_A[:, None], rng.uniform(0.02, 0.15))[:, 0]


def pulses(rng: np.random.Generator, course: Course, signal_nT: Array) -> Form:
    """A supply current that pulses: two or three harmonics, and a frequency that drifts by up to half a cycle."""
    count = course.current_A.shape[1]
    drive = course.current_A.sum(axis=1) if rng.uniform() < 0.5 else course.current_A[:, int(rng.integers(count))]
    tone_hz = rng.uniform(0.3, 0.4 / (STEP_S * course.every))
    x = course.time_s / course.duration_s
    cycles = tone_hz * course.time_s + rng.uniform(-0.25, 0.25) * x**2
    axes = np.stack([way(rng) for _ in range(3)])
    shares = np.array([1.0, rng.uniform(0.02, 0.2), rng.uniform(0.0, 0.1)])
    waves = np.stack([np.sin(2 * np.pi * (k + 1) * cycles + rng.uniform(0, 6)) for k in range(3)], axis=1)
    return linear(drive[:, None] * (waves * shares) @ axes)
