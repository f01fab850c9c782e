"""Intervals between time stamps: which samples are neighbours, and how far apart they usually are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array

GAP = 1.5
"""Intervals, in medians, beyond which two samples are not neighbours."""


def gaps_after(time_s: Array) -> NDArray[np.intp]:
    """Indices of samples after which more than GAP median intervals of time_s (n,) pass."""
    step = np.diff(time_s)
    return np.flatnonzero(step > GAP * np.median(step)) if len(step) else np.zeros(0, np.intp)


def usual_interval(time_s: Array) -> float:
    """Mean interval of times (n,) between gaps, s: unlike the median it is not that of rounded time stamps."""
    step = np.diff(time_s)
    return float(step[step <= GAP * np.median(step)].mean()) if len(step) else float("nan")
