"""Smoothing of recorded channels: their white measurement noise causes no disturbance."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
from scipy.fft import dct, idct

from calib.numerics.noise import white_noise_std
from diagnosis.problem.linear import LinearProblem
from recordings.channels import SCALAR
from scenarios.arrays import Array


def without_their_noise(problem: LinearProblem) -> LinearProblem:
    """The problem with smoothed channels, except channels whose noise is signal in the magnetometer.

    An effect driven by a noisy channel is estimated too small, and its lag too long.
    """
    channels = dict(problem.state.channels)
    for name, x in problem.state.channels.items():
        if name != SCALAR and np.isfinite(x).all():
            smooth = smoothed(x, problem.policy.bands)
            channels[name] = x if _is_seen(problem, x - smooth) else smooth
    return replace(problem, state=replace(problem.state, channels=channels))


def smoothed(x: Array, bands: int) -> Array:
    """A series (n,) without white noise: Wiener filter ``max(0, 1 - s^2 / P)`` of the mirrored series.

    P : power in bands evenly spaced in log frequency; s : white noise from differences of neighbours.
    """
    std = float(white_noise_std(x[:, None])[0])
    spectrum = dct(x, norm="ortho")
    edges = np.unique(np.geomspace(1, len(x), bands).astype(int))
    for a, b in itertools.pairwise(edges):
        spectrum[a:b] *= max(0.0, 1.0 - std**2 / max(float((spectrum[a:b] ** 2).mean()), 1e-300))
    return np.asarray(idct(spectrum, norm="ortho"))


def _is_seen(problem: LinearProblem, taken: Array) -> bool:
    """Whether the noise removed from a channel (n,) is correlated with the target, on any sensor axis."""
    columns = problem.sensor_axes(taken)
    squares = np.maximum((columns**2).sum(axis=(0, 1)), 1e-300)
    nats = (np.einsum("nqk,nq->k", columns, problem.target) ** 2 / squares).sum() / 2
    return bool(nats > problem.policy.apart)
