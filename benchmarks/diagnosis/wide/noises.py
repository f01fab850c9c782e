"""What a sensor, its clock and its attitude add by chance: white noise unequal on axes, and colours below or at it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from benchmarks.diagnosis.wide.courses import STEP_S, Course
from recordings import Recording
from scenarios.arrays import Array
from sim.rotation import multiply_q, q_from_rotation_vector


@dataclass(frozen=True)
class Noise:
    """White noise of each axis (3,) in nT and a colour of a size in units of it; no colour: None."""

    white_nT: Array
    colour: str | None
    size: float

    @property
    def sigma_nT(self) -> float:
        """Rms over the axes: what a strength is in units of."""
        return float(np.sqrt((self.white_nT**2).mean()))


def drawn(rng: np.random.Generator, colour: str | None, size: float) -> Noise:
    """Axes of 1 to 8 nT that differ by up to two."""
    level = np.exp(rng.uniform(np.log(1.0), np.log(8.0)))
    return Noise(level * rng.uniform(0.7, 1.4, 3), colour, size)


def measured(noise: Noise, course: Course, mag_nT: Array, rng: np.random.Generator) -> Recording:
    """A recording of a field (n, 3) with all that chance adds."""
    n = len(mag_nT)
    size_nT = noise.size * noise.sigma_nT
    if noise.colour in SLOW:
        mag_nT = mag_nT + size_nT * SLOW[noise.colour](rng, n)
    if noise.colour == CLOCK:
        mag_nT = _sampled_beside(mag_nT, course, size_nT, rng)
    recording = course.recorded(mag_nT, rng)
    recording = replace(recording, mag_nT=recording.mag_nT + noise.white_nT * rng.normal(size=recording.mag_nT.shape))
    return _with_attitude_error(recording, course, noise, rng) if noise.colour in TURNS else recording


def powers(rng: np.random.Generator, n: int, exponent: float) -> Array:
    """Noise (n, 3) of rms one with a density that falls with a power of the frequency."""
    f = np.fft.rfftfreq(2 * n, STEP_S)
    f[0] = f[1]
    parts = rng.normal(size=(len(f), 3)) + 1j * rng.normal(size=(len(f), 3))
    x = np.fft.irfft(parts * f[:, None] ** (-exponent / 2), axis=0)[:n]
    x -= x.mean(axis=0)
    return np.asarray(x / x.std())


def _remembered(rng: np.random.Generator, n: int) -> Array:
    """A process with one memory of seconds to minutes."""
    a = np.exp(-STEP_S / np.exp(rng.uniform(np.log(2.0), np.log(120.0))))
    x = lfilter([np.sqrt(1 - a**2)], [1.0, -a], rng.normal(size=(n, 3)), axis=0)
    return np.asarray(x)


def _sampled_beside(mag_nT: Array, course: Course, size_nT: float, rng: np.random.Generator) -> Array:
    """Values taken beside their time stamps, so that the error has a given rms."""
    rate = np.gradient(mag_nT, STEP_S, axis=0)
    jitter_s = size_nT / max(float(np.sqrt((rate**2).mean())), 1e-9) * rng.normal(size=len(mag_nT))
    return np.asarray(CubicSpline(course.time_s, mag_nT)(np.clip(course.time_s + jitter_s, 0, course.duration_s)))


def _with_attitude_error(recording: Recording, course: Course, noise: Noise, rng: np.random.Generator) -> Recording:
    """Navigation's attitude with an error that turns the field by the colour's size, rms of an axis."""
    n = len(recording)
    assert recording.att_q is not None
    error = rng.normal(size=(n, 3)) if noise.colour == "attitude, white" else powers(rng, n, 2.0)
    scale = noise.size * noise.sigma_nT / float(np.linalg.norm(course.field_enu_nT)) * np.sqrt(1.5)
    return replace(recording, att_q=multiply_q(q_from_rotation_vector(scale * error), np.array(recording.att_q)))


SLOW: dict[str | None, Callable[[np.random.Generator, int], Array]] = {
    "flicker": lambda rng, n: powers(rng, n, rng.uniform(0.8, 1.3)),
    "walk": lambda rng, n: powers(rng, n, 2.0),
    "steep": lambda rng, n: powers(rng, n, 3.0),
    "memory": _remembered,
}
"""Colour of the sensor's own -> (rng, n) -> noise (n, 3) of rms about one."""
CLOCK = "clock"
TURNS = ("attitude, white", "attitude, walk")
COLOURS = (*(name for name in SLOW if name), CLOCK, *TURNS)
