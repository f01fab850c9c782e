"""First-order lag of a signal at uneven times."""

from __future__ import annotations

import numpy as np

from scenarios.arrays import Array
from scenarios.kernel_cache import njit


@njit(cache=True)
def lagged(x: Array, time_s: Array, lag_s: float) -> Array:
    """Response y (n,) of lag dy/dt = x - y, exact for x (n,) linear between increasing times (n,), steady at first.

    y_k = a y_k-1 + (1 - c) x_k + (c - a) x_k-1,  a = exp(-h / lag),  c = (1 - a) lag / h
    """
    out = np.empty(len(x))
    state = x[0]
    out[0] = state
    for k in range(1, len(x)):
        step = (time_s[k] - time_s[k - 1]) / lag_s
        if step > 0.0:
            left = np.exp(-step)
            share = -np.expm1(-step) / step
            state = left * state + (1.0 - share) * x[k] + (share - left) * x[k - 1]
        out[k] = state
    return out
