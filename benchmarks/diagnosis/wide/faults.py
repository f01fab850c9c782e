"""What converter, electronics and noise do, at the size that is drawn."""

from __future__ import annotations

import numpy as np

from benchmarks.diagnosis.wide.noises import Noise, powers
from recordings import Recording
from scenarios.arrays import Array


def bursts(rng: np.random.Generator, recording: Recording, noise: Noise) -> Array:
    """Wrong values in runs of one to four samples, each run on one axis or all."""
    mag, step = recording.mag_nT.copy(), np.median(np.diff(recording.time_s))
    count = max(6, rng.poisson(rng.uniform(0.02, 0.15) * len(mag) * step))
    for at in rng.integers(0, len(mag) - 5, count):
        length = int(rng.integers(1, 5))
        size = noise.sigma_nT * rng.uniform(15, 60) * rng.choice([-1, 1], (length, 3))
        mag[at : at + length] += size * (np.ones(3) if rng.uniform() < 0.3 else np.eye(3)[rng.integers(3)])
    return np.asarray(mag)


def holds(rng: np.random.Generator, recording: Recording, noise: Noise) -> Array:
    """Values that stand still for a quarter of a second to two."""
    mag, step = recording.mag_nT.copy(), np.median(np.diff(recording.time_s))
    for at in rng.integers(1, len(mag) - 1, int(rng.integers(8, 25))):
        length = max(2, round(float(rng.uniform(0.25, 2.0) / step)))
        mag[at : at + length] = mag[at - 1]
    return np.asarray(mag)


def steps(rng: np.random.Generator, recording: Recording, noise: Noise) -> Array:
    """Values cut down to a converter's step."""
    step_nT = noise.sigma_nT * rng.uniform(0.5, 4.0)
    return np.asarray(np.floor(recording.mag_nT / step_nT) * step_nT)


def full_scale(rng: np.random.Generator, recording: Recording, noise: Noise) -> Array:
    """One end of the converter's range."""
    level = rng.uniform(0.85, 0.97) * np.abs(recording.mag_nT).max()
    return np.clip(recording.mag_nT, -level, level)


def wander(rng: np.random.Generator, recording: Recording, noise: Noise) -> Array:
    """An offset that walks about by some times the noise."""
    return np.asarray(recording.mag_nT + noise.sigma_nT * rng.uniform(1, 5) * powers(rng, len(recording), 2.0))


def flicker(rng: np.random.Generator, recording: Recording, noise: Noise) -> Array:
    """Noise whose density falls with the frequency."""
    return np.asarray(recording.mag_nT + noise.sigma_nT * rng.uniform(0.5, 3) * powers(rng, len(recording), 1.0))
