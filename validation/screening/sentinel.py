"""Sentinels: values that stand for a missing one, such as 99999 or three zeros."""

from __future__ import annotations

import numpy as np

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
    rows: Mask = np.asarray(~mag_nT.any(axis=1))
    parts = [f"0 on all axes ({counted(int(rows.sum()), 'row')})"] if rows.any() else []
    for axis, column in enumerate(mag_nT.T):
        for value in _isolated(column[~rows]):
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
        high, low = _end(rest), _end(-rest)
        value, gap, often = max((high, (-low[0], *low[1:])), key=lambda end: end[1])
        span = float(np.ptp(rest)) - gap
        if not gap or gap < POLICY.sentinel_gap * span or not _stands_for_nothing(value, gap, often, column):
            break
        found.append(value)
        rest = rest[rest != value]
    return found


def _end(column: Array) -> tuple[float, float, int]:
    """Return the greatest value of an axis (n,), its distance to the next, and how often it occurs."""
    value = float(column.max())
    below = column[column < value]
    gap = value - float(below.max()) if len(below) else 0.0
    return value, gap, len(column) - len(below)


def _stands_for_nothing(value: float, gap: float, often: int, column: Array) -> bool:
    """Return whether an extreme value has a known code, or occurs again beyond ten usual steps of its axis (n,)."""
    digits = f"{abs(value):.10g}".replace(".", "").strip("0")
    if digits in CODES or often == 1:
        return digits in CODES
    step = np.abs(np.diff(column))
    return bool(gap > POLICY.sentinel_steps * np.median(step[step > 0]))
