"""A signal interpolated from neighbouring samples, without the error of the sample at the time."""

from __future__ import annotations

import numpy as np

from scenarios.arrays import Array
from validation.policy import POLICY

PLACES = (-2, -1, 1, 2)
"""Samples that a cubic passes through, relative to the sample to be interpolated."""

MOST_SAMPLES = 5000
"""Samples, evenly spread, that a column is regressed on the signal with."""


def by_neighbours(signal: Array, time_s: Array, most: Array) -> Array:
    """Return a signal (n, 3) at times (n,), each sample from a cubic through two neighbours on either side.

    ``sum_i s_i prod_(j != i) (t - t_j) / (t_i - t_j)``. Where the cubic differs from the sample by more than `most`
    (3,), the signal bends too fast and the sample is kept; likewise the first and the last two samples.
    """
    out, n, edge = signal.copy(), len(signal), max(PLACES)
    if n <= 2 * edge:
        return out
    middle = slice(edge, n - edge)
    at = np.arange(n)[middle, None] + np.array(PLACES)
    weight = _weights(time_s[middle], time_s[at])
    read = np.einsum("ni,nij->nj", weight, signal[at])
    even = (np.abs(weight).sum(axis=1) < POLICY.neighbours_weight)[:, None]
    out[middle] = np.where(even & (np.abs(read - signal[middle]) < most), read, signal[middle])
    return out


def as_iron_sees(columns: Array, read: Array, signal: Array) -> Array:
    """Return columns (n, 3, k) computed from the interpolated signal `read`, with their linear part from `signal`.

    The iron of the baseline multiplies the measured signal (n, 3). A linear part computed from `read` (n, 3) would
    leave the difference, which is the error of the samples. The linear part is fitted to evenly spread samples:
    columns of a hysteresis loop that never closes are linear throughout.
    """
    some = slice(None, None, -(-len(signal) // MOST_SAMPLES))
    design = np.column_stack([read[some], np.full(len(read[some]), np.abs(read).max())])
    flat = columns[some].reshape(len(design), -1)
    linear = np.linalg.lstsq(design.T @ design, design.T @ flat, rcond=1e-12)[0][:3]
    corrected = (signal - read) @ linear
    corrected += columns.reshape(corrected.shape)
    return np.asarray(corrected.reshape(columns.shape))


def _weights(time_s: Array, there_s: Array) -> Array:
    """Return weights (n, m) of values at times (n, m) in the polynomial read at times (n,); large for equal times."""
    ahead = time_s[:, None] - there_s
    apart = there_s[:, :, None] - there_s[:, None, :]
    m = there_s.shape[1]
    factors = [[j for j in range(m) if j != i] for i in range(m)]
    above = np.stack([ahead[:, others].prod(axis=1) for others in factors], axis=1)
    below = np.stack([apart[:, i, others].prod(axis=1) for i, others in enumerate(factors)], axis=1)
    return np.asarray(np.divide(above, below, out=np.full_like(above, POLICY.neighbours_weight), where=below != 0))
