"""Kalman filter of coloured noise: white noise and slow processes, each along a direction."""

from __future__ import annotations

import numpy as np

from calib.numerics.kernels import fast_kernel
from scenarios.arrays import Array


@fast_kernel
def innovations(
    columns: Array, toward: Array, processes: tuple[Array, ...], white: float, usable: Array
) -> tuple[Array, Array]:
    """Innovations (n, k) of columns (n, k) over their standard deviation, and ``ln S`` (n,), S their variance.

    ``y_i = toward_i . x_i + white``, ``x_i = decay x_(i-1) + w_i``: toward (n, m) is how a sample sees the processes;
    processes are var x_0 (m,), decay and var w (n - 1, m). Where usable (n,) is 0 a sample teaches nothing: 0 and 0.
    """
    size, decay, kick = processes
    n, k = columns.shape
    m = toward.shape[1]
    out, ln_S, state, gain, P = np.zeros((n, k)), np.zeros(n), np.zeros((m, k)), np.empty(m), np.diag(size)
    for i in range(n):
        if i > 0:
            for a in range(m):
                for b in range(m):
                    P[a, b] *= decay[i - 1, a] * decay[i - 1, b]
                P[a, a] += kick[i - 1, a]
                for j in range(k):
                    state[a, j] *= decay[i - 1, a]
        if usable[i] == 0:
            continue
        variance = white
        for a in range(m):
            gain[a] = 0.0
            for b in range(m):
                gain[a] += P[a, b] * toward[i, b]
            variance += gain[a] * toward[i, a]
        ln_S[i] = np.log(variance)
        for j in range(k):
            off = columns[i, j]
            for a in range(m):
                off -= toward[i, a] * state[a, j]
            out[i, j] = off / np.sqrt(variance)
            for a in range(m):
                state[a, j] += gain[a] * off / variance
        for a in range(m):
            for b in range(m):
                P[a, b] -= gain[a] * gain[b] / variance
    return out, ln_S
