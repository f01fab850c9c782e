"""Compiled loops over samples shared by several effects; sequential, with equal bits on every machine."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

import numpy as np

from scenarios.arrays import Array
from scenarios.kernel_cache import njit

P = ParamSpec("P")
T = TypeVar("T")


def kernel(function: Callable[P, T]) -> Callable[P, T]:
    """Compile a loop over samples: cached on disk, free of the interpreter's lock, numpy's division by zero."""
    compiled: Callable[P, T] = njit(cache=True, nogil=True, error_model="numpy")(function)
    return compiled


@kernel
def times(matrix: Array, signal: Array) -> Array:
    """matrix @ signal for each sample: matrix (3, 3), signal (n, 3)."""
    product = np.empty((len(signal), 3))
    for i in range(len(signal)):
        x, y, z = signal[i, 0], signal[i, 1], signal[i, 2]
        for j in range(3):
            product[i, j] = matrix[j, 0] * x + matrix[j, 1] * y + matrix[j, 2] * z
    return product


@kernel
def _lag(signal: Array, before: Array, state: Array, decay: float, new: float, old: float) -> Array:
    out = np.empty_like(signal)
    for i in range(len(signal)):
        for j in range(signal.shape[1]):
            state[j] = decay * state[j] + new * signal[i, j] + old * before[j]
            before[j] = signal[i, j]
            out[i, j] = state[j]
    return out


def first_order_lag(signal: Array, time_constant_s: float, interval_s: float, memory: dict[str, Array]) -> Array:
    """Response y (n, q) of tau dy/dt = x - y, exact for an input x (n, q) linear between samples.

    ``y_k = a y_k-1 + b x_k + c x_k-1,  a = exp(-h/tau),  b = 1 - (tau/h)(1 - a),  c = (tau/h)(1 - a) - a``.
    A ramp comes out tau late whatever the sample interval h, also for tau << h. The initial state is steady.
    """
    if not memory:
        memory["before"], memory["state"] = signal[0].copy(), signal[0].copy()
    ratio = interval_s / time_constant_s
    share = -math.expm1(-ratio) / ratio
    decay = math.exp(-ratio)
    return _lag(signal, memory["before"], memory["state"], decay, 1.0 - share, share - decay)


def curved_lag(signal: Array, time_constant_s: float, interval_s: float, memory: dict[str, Any]) -> Array:
    """Response y (n, q) of tau dy/dt = x - y, exact for an x (n, q) of parabolas through three samples.

    `first_order_lag` plus ``z_k = a z_k-1 + q (x_k - 2 x_k-1 + x_k-2)``,
    ``q = ((tau/h)(1 - a) (1 + 2 tau/h) - 2 tau/h) / 2``. For tau << h the rate of a line is half an interval late, the
    rate of a parabola is in time.
    """
    if not memory:
        memory["past"], memory["bent"] = np.stack([signal[0], signal[0]]), np.zeros(signal.shape[1])
    past = np.concatenate([memory["past"], signal])
    bend = past[2:] - 2 * past[1:-1] + past[:-2]
    memory["past"] = past[-2:].copy()
    ratio = interval_s / time_constant_s
    share = -math.expm1(-ratio) / ratio
    part = (share - 2 * (1 - share) / ratio) / 2
    bent = _lag(bend, np.zeros(signal.shape[1]), memory["bent"], math.exp(-ratio), part, 0.0)
    return first_order_lag(signal, time_constant_s, interval_s, memory.setdefault("line", {})) + bent
