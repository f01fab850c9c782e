"""Filters with memory on recordings with uneven sample times."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.interpolate import Akima1DInterpolator

from scenarios.arrays import Array
from sim.state import SPARSEST as SPARSEST
from sim.state import State

UNEVEN = 0.05
"""Largest deviation of even time steps, in intervals: larger than the rounding of time stamps."""


def respond_on_even_grid(state: State, signal_nT: Array, respond: Callable[[Array], Array]) -> Array:
    """Response to a signal (n, 3), computed on an even grid and interpolated back to the sample times.

    Signal and added response are interpolated by smooth curves (Akima's); gaps are bridged.
    """
    time_s, step_s = state.time_s, state.interval_s
    uneven = np.abs(np.diff(time_s) - step_s).max(initial=0.0) > UNEVEN * step_s
    if not uneven or time_s[-1] - time_s[0] > SPARSEST * len(time_s) * step_s:
        return respond(signal_nT)
    grid_s = time_s[0] + step_s * np.arange(int(np.ceil((time_s[-1] - time_s[0]) / step_s)) + 1)
    even = Akima1DInterpolator(np.append(time_s, grid_s[-1] + step_s), np.vstack([signal_nT, signal_nT[-1:]]))(grid_s)
    return np.asarray(signal_nT + Akima1DInterpolator(grid_s, respond(even) - even)(time_s))
