"""Sentinels: values that stand for a missing one, such as 99999 or three zeros."""

from __future__ import annotations

from operator import itemgetter

import numpy as np

from calib.numerics.scans import extremes, zero_rows
from recordings import Recording
from scenarios.arrays import Array
from validation.policy import POLICY
from validation.screening.fault import AXES, Fault, Mask
from validation.text import counted, figure, listed

CODES = ("99999", "9999", "999", "88888", "32767", "32768", "65535", "2147483647", "2147483648")
"""Digits of values that loggers and converters write for a missing one, in any power of ten."""
MOST = 4
"""Sentinels of an axis at most."""


def sentinels(recording: Recording) -> list[Fault]:
    """Return the rows with a value far from all others that occurs again or has the digits of a known code."""
    mag_nT = recording.mag_nT
    rows: Mask = np.asarray(~mag_nT.any(axis=1)) if zero_rows(mag_nT) else np.zeros(len(mag_nT), np.bool_)
    parts = [f"0 on all axes ({counted(int(rows.sum()), 'row')})"] if rows.any() else []
    for axis, column in enumerate(mag_nT.T):
        for value in _isolated(column[~rows] if rows.any() else np.ascontiguousarray(column)):
            equal = column == value
            parts.append(f"{figure(value, 6)} nT on {AXES[axis]} ({counted(int(equal.sum()), 'row')})")
            rows |= equal
    if not parts:
        return []
    return [Fault("sentinel", f"a sentinel stands for a missing value: {listed(parts)}", rows)]


def _isolated(column: Array) -> list[float]:
    """Return the sentinels among the values of an axis (n,): one end of the range after the other."""
    found: list[float] = []
    rest = column
    while len(found) < MOST and len(rest) > POLICY.least_codes:
        value, gap, often, span = _end(rest)
        if not gap or gap < POLICY.sentinel_gap * span or not _stands_for_nothing(value, gap, often, column):
            break
        found.append(value)
        rest = rest[rest != value]
    return found


def _end(column: Array) -> tuple[float, float, int, float]:
    """Return the extreme value of an axis (n,) that is further from the next, this gap, how often, and others' span."""
    low, next_low, low_count, high, next_high, high_count = (ends[0] for ends in extremes(column[:, None]))
    if low == high:
        return float(high), 0.0, int(high_count), 0.0
    gap, value, often = max((high - next_high, high, high_count), (next_low - low, low, low_count), key=itemgetter(0))
    return float(value), float(gap), int(often), float(high - low - gap)


def _stands_for_nothing(value: float, gap: float, often: int, column: Array) -> bool:
    """Return whether an extreme value has a known code, or occurs again beyond ten usual steps of its axis (n,)."""
    digits = f"{abs(value):.10g}".replace(".", "").strip("0")
    if digits in CODES or often == 1:
        return digits in CODES
    step = np.abs(np.diff(column))
    return bool(gap > POLICY.sentinel_steps * np.median(step[step > 0]))
