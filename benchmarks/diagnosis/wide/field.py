"""Fields from outside the vehicle, in forms that no candidate has."""

from __future__ import annotations

import numpy as np

from benchmarks.diagnosis.wide.courses import Course
from benchmarks.diagnosis.wide.forms import Form, linear, way
from scenarios.arrays import Array
from sim.rotation import to_body

NEAREST_M = 3.0
"""Least distance of a body from the path."""


def constant_error(rng: np.random.Generator, course: Course, signal_nT: Array) -> Form:
    """A field that differs from the given one, by a fiftieth more or less along the way."""
    course_m = course.pos_enu_m @ way(rng)
    along = 1 + 0.02 * (course_m - course_m.mean()) / max(float(np.ptp(course_m)), 1.0)
    return linear(to_body(course.R_wb, along[:, None] * way(rng)))


def day(rng: np.random.Generator, course: Course, signal_nT: Array) -> Form:
    """A day's change in a run: a bent ramp, and a pulsation of some minutes that is a tenth of it."""
    x = course.time_s / course.duration_s
    bent = x + rng.uniform(-0.5, 0.5) * x**2
    pulse = np.sin(2 * np.pi * course.time_s / rng.uniform(200, 600) + rng.uniform(0, 6))
    world = bent[:, None] * way(rng) + rng.uniform(0, 0.1) * pulse[:, None] * way(rng)
    return linear(to_body(course.R_wb, world))


def gradient(rng: np.random.Generator, course: Course, signal_nT: Array) -> Form:
    """A gradient about an origin beside the path, with a second-order part of up to a fifth at its ends."""
    moved = course.pos_enu_m - course.pos_enu_m.mean(axis=0)
    reach = float(np.linalg.norm(moved, axis=1).max())
    g = rng.normal(size=(3, 3))
    g = (g + g.T) / 2
    g -= np.eye(3) * np.trace(g) / 3
    bend, up = way(rng), np.array([0.0, 0.0, 1.0])
    across = np.cross(bend, up) / np.linalg.norm(np.cross(bend, up))
    a, b = moved @ bend, moved @ across  # of the potential a^3 - 3 a b^2, which has no sources
    second = ((a**2 - b**2)[:, None] * bend - (2 * a * b)[:, None] * across) / reach
    origin = way(rng) * rng.uniform(0, 1) * reach
    world = (moved - origin) @ g.T + rng.uniform(0, 0.2) * np.linalg.norm(g) * second
    return linear(to_body(course.R_wb, world))


def body(rng: np.random.Generator, course: Course, signal_nT: Array) -> Form:
    """A body of finite size beside the path: two to four moments within a fifth of the least distance."""
    middle, nearest_m = course.pos_enu_m[0], 0.0
    while nearest_m < NEAREST_M:
        at = int(rng.integers(len(course.time_s) // 5, 4 * len(course.time_s) // 5))
        middle = course.pos_enu_m[at] + rng.uniform(4, 9) * way(rng) * np.array([1, 1, 0.7])
        nearest_m = float(np.linalg.norm(course.pos_enu_m - middle, axis=1).min())
    world = np.zeros((len(course.time_s), 3))
    main = way(rng)
    for _ in range(int(rng.integers(2, 5))):
        r = course.pos_enu_m - (middle + nearest_m / 5 * rng.uniform(-1, 1, 3))
        m = main + 0.4 * rng.normal(size=3)
        size = np.linalg.norm(r, axis=1, keepdims=True)
        world += 3 * (r @ m)[:, None] * r / size**5 - m / size**3
    return linear(to_body(course.R_wb, world))


def turned(rng: np.random.Generator, course: Course, signal_nT: Array) -> Form:
    """An attitude turned on the world's side; a twentieth of the turn comes in the run."""
    axis = way(rng)
    growing = 1 + 0.05 * (course.time_s / course.duration_s - 0.5)
    return linear(to_body(course.R_wb, growing[:, None] * np.cross(axis, course.field_enu_nT) / 1e4))
