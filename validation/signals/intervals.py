"""Intervals between time stamps: gaps and the usual interval."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array
from validation.policy import POLICY


def gaps_after(time_s: Array) -> NDArray[np.intp]:
    """Return indices of samples before a gap in time_s (n,): an interval of more than 1.5 medians."""
    step = np.diff(time_s)
    return np.flatnonzero(step > POLICY.gap * np.median(step)) if len(step) else np.zeros(0, np.intp)


def usual_interval(time_s: Array) -> float:
    """Return the mean interval of times (n,) between gaps in s; unlike the median, not biased by rounded stamps."""
    step = np.diff(time_s)
    return float(step[step <= POLICY.gap * np.median(step)].mean()) if len(step) else float("nan")
