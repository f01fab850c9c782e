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
    """Return the sentinels among the values of an axis (n,)."""
    found: list[float] = []
    distinct, count = np.unique(column, return_counts=True)
    step = np.abs(np.diff(column))
    usual = float(np.median(step[step > 0])) if step.any() else 0.0
    while len(found) < MOST and len(distinct) > POLICY.least_codes:
        span = distinct[-2] - distinct[1]
        ends = (
            (distinct[-1], distinct[-1] - distinct[-2], count[-1]),
            (distinct[0], distinct[1] - distinct[0], count[0]),
        )
        value, gap, often = max(ends, key=lambda end: end[1])
        if not _stands_for_nothing(float(value), float(gap / span) if span else 0.0, float(gap), int(often), usual):
            break
        found.append(float(value))
        keep = distinct != value
        distinct, count = distinct[keep], count[keep]
    return found


def _stands_for_nothing(value: float, share: float, gap: float, often: int, usual: float) -> bool:
    """Return whether an extreme value is a sentinel, by its distance to the next value: share of the span, and nT."""
    digits = f"{abs(value):.10g}".replace(".", "").strip("0").removesuffix("e+")
    if share < POLICY.sentinel_gap:
        return False
    return digits in CODES or (often > 1 and gap > POLICY.sentinel_steps * usual)
