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
        """Return var x_0 (m,), rates (m,) and growths (m,) of the processes in the noise, see `innovations`.

        A process of variance d^2 ln r and corner f_k, corners r apart, has density d^2 ln r (2 / pi) f_k /
        (f^2 + f_k^2); the sum is d^2 / f between the corners. At the lowest corner the slow processes have the variance
        of a density that is flat below FLICKER_LOW_HZ.
        """
        lowest = FLICKER_LOW_HZ * 10.0 ** (0.5 / CORNERS_A_DECADE) / np.e
        highest = max(HIGHEST / float(np.median(step_s)), 10.0 * lowest)
        count = int(np.ceil(np.log10(highest / lowest) * CORNERS_A_DECADE)) + 1
        corners = np.geomspace(lowest, highest, count)
        size = np.append(np.full(count, self.flicker_nT_sqrt_hz**2 * np.log(corners[1] / corners[0])), 0.0)
        return size, 2.0 * np.pi * np.append(corners, 0.0), np.append(np.zeros(count), self.walk_nT_sqrt_s**2)


def whitened(rows: Array, noise_std_nT: float, colour: Colour | None, step_s: Array) -> Array:
    """Return rows (n, r, k) divided by the noise: (n r, k) with white noise of unit variance.

    K^(-1/2) J,  K the covariance of the rows' noise, by a Kalman filter over all columns. The first three columns of a
    row are the direction of the noise; the r rows of a sample must have noise of different axes.
    """
    if colour is None:
        return np.asarray(rows.reshape(-1, rows.shape[2]) / noise_std_nT)
    processes, time_s = colour.processes(step_s), np.append(0.0, np.cumsum(step_s))
    parts = []
    for row in rows.transpose(1, 0, 2):
        seen = [axis for axis in range(3) if row[:, axis].any()]
        toward = np.repeat(row[:, seen], len(processes[0]), axis=1)
        size, rate, growth = (np.tile(one, len(seen)) for one in processes)
        white, all_rows = np.full(len(row), noise_std_nT**2), np.ones(len(row))
        parts.append(innovations(row, toward, (size, rate, growth), time_s, white, all_rows)[0])
    return np.concatenate(parts)
