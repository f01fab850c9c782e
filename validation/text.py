"""Numbers, units and names as text in sentences and on pages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from scenarios.text import figure as figure

SYMBOLS = {"deg": "°"}
"""Symbols of units with words as names in files."""
MOST_PLACES = 4
"""Decimals beyond which a value and its interval are each written by their own digits."""
ATTACHED = ("°",)
"""Units that follow a number without a space."""


def quantity(value: float, unit: str) -> str:
    """Return a number with unit: "1234 nT", "0.02°", or "0.5" without unit."""
    mark = symbol(unit)
    return f"{figure(value)}{mark if mark in ATTACHED else f' {mark}'}".rstrip()


def measured(value: float, half: float) -> str:
    """Return a value and the half of its interval with the same decimals, the half with two digits: "5209 ± 38"."""
    if not (np.isfinite(value) and np.isfinite(half) and half > 0):
        return figure(value)
    places = max(0, 1 - int(np.floor(np.log10(half))))
    if places > MOST_PLACES:
        return f"{figure(value)} ± {figure(half, 2)}"
    return f"{round(value, places) + 0.0:.{places}f} ± {half:.{places}f}"  # the sum makes 0 of -0


def symbol(unit: str) -> str:
    """Return the symbol of a unit."""
    return SYMBOLS.get(unit, unit)


def figures(values: Sequence[float] | Any, significant: int = 3) -> str:
    """Return numbers for a sentence; a single number if all are equal."""
    texts = [figure(float(v), significant) for v in values]
    return texts[0] if len(set(texts)) == 1 else listed(texts)


def listed(texts: Sequence[str]) -> str:
    """Return "a", "a and b", "a, b and c"."""
    return ", ".join(texts[:-1]) + f" and {texts[-1]}" if len(texts) > 1 else "".join(texts)


def counted(number: int, what: str, many: str = "") -> str:
    """Return "1 gap", "2 gaps", "no gap"."""
    return f"no {what}" if number == 0 else f"1 {what}" if number == 1 else f"{number} {many or what + 's'}"


def all_of(number: int, what: str) -> str:
    """Return "both runs", "all 3 runs"."""
    return f"both {what}" if number == 2 else f"all {number} {what}"


def duration(seconds: float) -> str:
    """Return a length of time in a suitable unit."""
    for unit, size in (("d", 86_400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{figure(seconds / size)} {unit}"
    return f"{figure(1e3 * seconds)} ms" if 0 < seconds < 0.1 else f"{figure(seconds)} s"


def frequency(hertz: float) -> str:
    """Return a rate in Hz, or the period of a slow rate."""
    return f"{figure(hertz, 4)} Hz" if hertz >= 0.2 else f"one in {duration(1 / hertz)}" if hertz > 0 else "0 Hz"


def short(value: Any, significant: int = 3) -> str:
    """Return a value, or a list in brackets, its numbers with significant digits."""
    if isinstance(value, list):
        return "(" + ", ".join(short(v, significant) for v in value) + ")"
    return figure(value, significant) if isinstance(value, float) else str(value)


def given(value: Any) -> str:
    """Return a given value, or a list in brackets: up to seven digits, so that near values stay apart."""
    return short(value, 7)


def digits(value: float, significant: int = 3) -> str:
    """Return a measured number for a page: significant digits, with the zeros that tell the accuracy."""
    return _typeset(figure(value, significant, zeros=True))


def plainly(value: float) -> str:
    """Return a given or counted number for a page: up to seven digits, without trailing zeros."""
    return _typeset(figure(value, 7))


def _typeset(number: str) -> str:
    return number.replace("-", "−")


def sentence(text: str) -> str:
    """Return a clause as a sentence."""
    return f"{text[:1].upper()}{text[1:]}."


def words(name: str) -> str:
    """Return a name with spaces for underscores."""
    return name.replace("_", " ")
