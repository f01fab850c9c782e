"""Kalman filter of coloured noise: white noise and slow processes, each along a direction."""

from __future__ import annotations

import numpy as np

from calib.numerics.kernels import fast_kernel
from scenarios.arrays import Array

SAME_STEP = 1e-8
"""Relative difference of two time steps that is rounding of the time stamps."""


@fast_kernel
def innovations(
    columns: Array, toward: Array, processes: tuple[Array, ...], time_s: Array, white: Array, usable: Array
) -> tuple[Array, Array]:
    """Innovations (n, k) of columns (n, k) over their standard deviation, and ``ln S`` (n,), S their variance.

    ``y_i = toward_i . x_i + white``, ``x_i = decay x_(i-1) + w_i``: toward (n, m) is how a sample sees the processes.
    Processes are var x_0 (m,), rate and growth (m,): over a time t ``decay = exp(-rate t)`` and ``var w = (1 -
    decay^2) var x_0 + growth t``. White (n,): variances. Where usable (n,) is 0 a sample teaches nothing: 0 and 0.
    """
    size, rate, growth = processes
    n, k = columns.shape
    m = toward.shape[1]
    out, ln_S, P, last_s = np.zeros((n, k)), np.zeros(n), np.diag(size), 0.0
    state, gain, off, decay, kick = np.zeros((m, k)), np.empty(m), np.empty(k), np.empty(m), np.empty(m)
    for i in range(n):
        step_s = time_s[i] - time_s[i - 1] if i > 0 else 0.0
        if step_s > 0 and abs(step_s - last_s) > SAME_STEP * last_s:
            last_s = step_s
            for a in range(m):
                decay[a] = np.exp(-rate[a] * step_s)
                kick[a] = (1.0 - decay[a] ** 2) * size[a] + growth[a] * step_s
        for a in range(m if step_s > 0 else 0):
            for b in range(m):
                P[a, b] *= decay[a] * decay[b]
            P[a, a] += kick[a]
            for j in range(k):
                state[a, j] *= decay[a]
        if usable[i] == 0:
            continue
        variance = white[i]
        for a in range(m):
            gain[a] = 0.0
            for b in range(m):
                gain[a] += P[a, b] * toward[i, b]
            variance += gain[a] * toward[i, a]
        ln_S[i], scale = np.log(variance), 1.0 / np.sqrt(variance)
        off[:] = columns[i]
        for a in range(m):
            for j in range(k):
                off[j] -= toward[i, a] * state[a, j]
        for j in range(k):
            off[j] *= scale
            out[i, j] = off[j]
        for a in range(m):
            gain[a] *= scale
            for j in range(k):
                state[a, j] += gain[a] * off[j]
        for a in range(m):
            for b in range(m):
                P[a, b] -= gain[a] * gain[b]
    return out, ln_S
