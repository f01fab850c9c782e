"""Coloured noise, and rows whitened as by a method with knowledge of the spectrum."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from calib.numerics.innovations import innovations
from scenarios.arrays import Array
from sim.effects.noise import FLICKER_LOW_HZ

CORNERS_A_DECADE = 2
"""First-order processes a decade whose sum is flicker noise within 1 %."""
HIGHEST = 0.45
"""Highest corner frequency over the sample rate."""


@dataclass(frozen=True)
class Colour:
    """Coloured noise, equal on all axes: flicker of one-sided density d^2 / f, and a random walk of q sqrt(t)."""

    flicker_nT_sqrt_hz: float
    walk_nT_sqrt_s: float

    def processes(self, step_s: Array) -> tuple[Array, Array, Array]:
        """Return var x_0 (m,), decay and var w (n - 1, m) of processes ``x_(i+1) = decay_i x_i + w_i`` in the noise.

        A process of variance d^2 ln r and corner f_k, corners r apart, has density d^2 ln r (2 / pi) f_k /
        (f^2 + f_k^2); the sum is d^2 / f between the corners. At the lowest corner the slow processes have the variance
        of a density that is flat below FLICKER_LOW_HZ.
        """
        lowest = FLICKER_LOW_HZ * 10.0 ** (0.5 / CORNERS_A_DECADE) / np.e
        highest = max(HIGHEST / float(np.median(step_s)), 10.0 * lowest)
        count = int(np.ceil(np.log10(highest / lowest) * CORNERS_A_DECADE)) + 1
        corners = np.geomspace(lowest, highest, count)
        size = np.append(np.full(count, self.flicker_nT_sqrt_hz**2 * np.log(corners[1] / corners[0])), 0.0)
        decay = np.exp(-2.0 * np.pi * step_s[:, None] * np.append(corners, 0.0))
        kick = size * (1.0 - decay**2)
        kick[:, -1] = self.walk_nT_sqrt_s**2 * step_s
        return size, decay, kick


def whitened(rows: Array, noise_std_nT: float, colour: Colour | None, step_s: Array) -> Array:
    """Return rows (n, r, k) divided by the noise: (n r, k) with white noise of unit variance.

    K^(-1/2) J,  K the covariance of the rows' noise, by a Kalman filter over all columns. The first three columns of a
    row are the direction of the noise; the r rows of a sample must have noise of different axes.
    """
    if colour is None:
        return np.asarray(rows.reshape(-1, rows.shape[2]) / noise_std_nT)
    size, decay, kick = colour.processes(step_s)
    parts = []
    for row in rows.transpose(1, 0, 2):
        seen = [axis for axis in range(3) if row[:, axis].any()]
        toward = np.repeat(row[:, seen], len(size), axis=1)
        own = (np.tile(one, len(seen)) for one in (size, decay, kick))
        white, all_rows = noise_std_nT**2, np.ones(len(row))
        parts.append(innovations(np.ascontiguousarray(row), toward, (*own,), white, all_rows)[0])
    return np.concatenate(parts)
