"""Series thinned for drawing: extremes of buckets, and strides."""

from __future__ import annotations

import numpy as np

from scenarios.arrays import Array


def envelope(time_s: Array, values: Array, buckets: int = 700) -> tuple[Array, Array]:
    """Thin a record (n,) or (n, k) for drawing: least and greatest value of each bucket of consecutive samples.

    Spikes of a single sample remain visible. Returns times (m,) and values (m,) or (m, k), m <= 2 buckets; shorter
    records are returned unchanged. A bucket of NaN alone (a gap) gives NaN.
    """
    n = len(time_s)
    if n <= 2 * buckets:
        return time_s, values
    starts = np.arange(0, n, -(-n // buckets))
    middle = (starts + np.append(starts[1:], n)) // 2
    low, high = np.fmin.reduceat(values, starts, axis=0), np.fmax.reduceat(values, starts, axis=0)
    times = np.stack([time_s[starts], time_s[middle]], axis=1).ravel()
    return times, np.stack([low, high], axis=1).reshape(len(times), *values.shape[1:])


def every_nth(n: int, most: int) -> slice:
    """Return a slice that keeps at most `most` of n samples, evenly spread."""
    return slice(None, None, max(1, -(-n // most)))
