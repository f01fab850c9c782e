"""The course of a signal by neighbouring samples, in which a sample's own error has no part."""

from __future__ import annotations

import numpy as np

from scenarios.arrays import Array

PLACES = (-2, -1, 1, 2)
"""The samples that a cubic is laid through, from the one that it is read at."""
MOST_WEIGHT = 2.0
"""Sum of the cubic's weights' sizes beyond which uneven times make noise large: 5/3 where times are even."""

MOST_SAMPLES = 5000
"""Samples, spread evenly, from which it is read what of a column is linear in the signal."""


def by_neighbours(signal: Array, time_s: Array, most: Array) -> Array:
    """A signal (n, 3) at times (n,), each sample read from a cubic through two on either side of it.

    ``sum_i s_i prod_(j != i) (t - t_j) / (t_i - t_j)``. Where that is further off than `most` (3,), the signal bends
    too fast for it and a sample stays as it is; so do the first and the last two.
    """
    out, n, edge = signal.copy(), len(signal), max(PLACES)
    if n <= 2 * edge:
        return out
    middle = slice(edge, n - edge)
    at = np.arange(n)[middle, None] + np.array(PLACES)
    weight = _weights(time_s[middle], time_s[at])
    read = np.einsum("ni,nij->nj", weight, signal[at])
    even = (np.abs(weight).sum(axis=1) < MOST_WEIGHT)[:, None]
    out[middle] = np.where(even & (np.abs(read - signal[middle]) < most), read, signal[middle])
    return out


def as_iron_sees(columns: Array, read: Array, signal: Array) -> Array:
    """Columns (n, 3, k) made of a signal as it is read (n, 3), with what is linear in that made of the signal (n, 3).

    The base has the signal itself, and would make the difference of the two, which is the sample's own error. What is
    linear is read from some of the samples: all of a loop that never closes is.
    """
    some = slice(None, None, -(-len(signal) // MOST_SAMPLES))
    design = np.column_stack([read[some], np.full(len(read[some]), np.abs(read).max())])
    flat = columns[some].reshape(len(design), -1)
    linear = np.linalg.lstsq(design.T @ design, design.T @ flat, rcond=1e-12)[0][:3]
    return np.asarray(columns + ((signal - read) @ linear).reshape(columns.shape))


def _weights(time_s: Array, there_s: Array) -> Array:
    """Weights (n, m) of values at times (n, m) in the polynomial through them at times (n,); large for two at one."""
    ahead = time_s[:, None] - there_s
    apart = there_s[:, :, None] - there_s[:, None, :]
    m = there_s.shape[1]
    factors = [[j for j in range(m) if j != i] for i in range(m)]
    above = np.stack([ahead[:, others].prod(axis=1) for others in factors], axis=1)
    below = np.stack([apart[:, i, others].prod(axis=1) for i, others in enumerate(factors)], axis=1)
    return np.asarray(np.divide(above, below, out=np.full_like(above, MOST_WEIGHT), where=below != 0))
