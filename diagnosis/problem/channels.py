"""Recorded channels without their own white noise, which is no cause of anything."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
from scipy.fft import dct, idct

from calib.numerics.noise import white_noise_std
from diagnosis.problem.linear import LinearProblem
from recordings.channels import SCALAR
from scenarios.arrays import Array
from sim.effects.channels import ChannelEffect


def without_their_noise(problem: LinearProblem) -> LinearProblem:
    """The problem with its channels smoothed, but for those whose noise the magnetometer sees too: that is no noise.

    An effect that follows a channel with errors of its own comes out too small, and rather late than noisy.
    """
    channels = dict(problem.state.channels)
    for name, x in problem.state.channels.items():
        if name != SCALAR and np.isfinite(x).all():
            smooth = smoothed(x, problem.policy.bands)
            channels[name] = x if _is_seen(problem, x - smooth) else smooth
    return replace(problem, state=replace(problem.state, channels=channels))


def smoothed(x: Array, bands: int) -> Array:
    """A series (n,) less its white noise: Wiener's filter ``max(0, 1 - s^2 / P)`` of a mirrored series.

    P : power in bands evenly spaced in log frequency; s : white noise by the differences of neighbours.
    """
    std = float(white_noise_std(x[:, None])[0])
    spectrum = dct(x, norm="ortho")
    edges = np.unique(np.geomspace(1, len(x), bands).astype(int))
    for a, b in itertools.pairwise(edges):
        spectrum[a:b] *= max(0.0, 1.0 - std**2 / max(float((spectrum[a:b] ** 2).mean()), 1e-300))
    return np.asarray(idct(spectrum, norm="ortho"))


def _is_seen(problem: LinearProblem, taken: Array) -> bool:
    """Whether what is taken from a channel (n,) is seen in the target, on any axis of the sensor."""
    columns = problem.whitened(taken[:, None, None] * np.eye(3), ChannelEffect)
    squares = np.maximum((columns**2).sum(axis=(0, 1)), 1e-300)
    nats = (np.einsum("nqk,nq->k", columns, problem.target) ** 2 / squares).sum() / 2
    return bool(nats > problem.policy.apart)
