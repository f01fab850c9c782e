"""Held values: a log with more rows than its sensor has samples."""

from __future__ import annotations

import numpy as np

from calib.numerics.scans import run_counts
from scenarios.arrays import Array
from validation.policy import POLICY
from validation.signals.faults import repeats, runs


def stale(values: Array) -> bool:
    """Return whether rows of values (n, k) repeat because the column is slower, not because the value is constant."""
    if len(values) < POLICY.least_rate_rows or 1.0 - run_counts(values).runs / len(values) < POLICY.stale_share:
        return False  # fewer still without the frozen rows
    for first, rows in reversed(repeats(values).frozen):
        values = np.delete(values, np.s_[first + 1 : first + rows], axis=0)
    _, length = runs(values)
    near = 1.0 - len(length) / len(values)
    lag = max(2, int(np.ceil(POLICY.stale_lag * len(values) / len(length))))
    if near < POLICY.stale_share or lag >= len(values) // 2:
        return False
    far = float(np.mean(np.all(values[lag:] == values[:-lag], axis=1)))
    return near > POLICY.stale_ratio * far
