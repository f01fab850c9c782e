"""Numbers as text: one form on the terminal, on pages and in reasons."""

from __future__ import annotations

import numpy as np

SMALLEST, LARGEST = 1e-4, 1e6
"""Sizes outside which numbers are written with a power of ten."""


def figure(value: float, significant: int = 3, *, zeros: bool = False) -> str:
    """Return a number with significant digits, "48152", "0.021" or "1.9e6"; a dash for NaN and infinity.

    Digits before the decimal point are all kept, and none is separated from the others.
    zeros : keep trailing zeros, which indicate the accuracy.
    """
    if not np.isfinite(value):
        return "–"
    if value == 0:
        return "0"
    mantissa, power = f"{value:.{significant - 1}e}".split("e")
    if SMALLEST <= abs(value) < LARGEST:
        return _cut(f"{value:.{max(0, significant - 1 - int(power))}f}", zeros)
    return f"{_cut(mantissa, zeros)}e{int(power)}"


def _cut(text: str, zeros: bool) -> str:
    return text.rstrip("0").rstrip(".") if "." in text and not zeros else text
