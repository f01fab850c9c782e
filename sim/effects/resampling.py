"""What remembers the samples before, along a recording whose samples are not evenly spaced."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.interpolate import Akima1DInterpolator

from scenarios.arrays import Array
from sim.state import State

UNEVEN = 0.05
"""Difference from the interval, in intervals, from which on steps of time are uneven: rounded stamps stay below it."""
SPARSEST = 4
"""Even samples to one of the recording beyond which it is mostly gaps: taken sample by sample, without a spectrum."""


def respond_on_even_grid(state: State, signal_nT: Array, respond: Callable[[Array], Array]) -> Array:
    """What `respond` makes of a signal (n, 3) that it needs evenly spaced: on such a grid, and back at the true times.

    Between samples the signal is a smooth curve (Akima's), and what the response adds to it another; a gap is bridged.
    """
    time_s, step_s = state.time_s, state.interval_s
    uneven = np.abs(np.diff(time_s) - step_s).max(initial=0.0) > UNEVEN * step_s
    if not uneven or time_s[-1] - time_s[0] > SPARSEST * len(time_s) * step_s:
        return respond(signal_nT)
    grid_s = time_s[0] + step_s * np.arange(int(np.ceil((time_s[-1] - time_s[0]) / step_s)) + 1)
    even = Akima1DInterpolator(np.append(time_s, grid_s[-1] + step_s), np.vstack([signal_nT, signal_nT[-1:]]))(grid_s)
    return np.asarray(signal_nT + Akima1DInterpolator(grid_s, respond(even) - even)(time_s))
