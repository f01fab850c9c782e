"""Numbers and names in sentences: one way to write each, in text and on pages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

SMALLEST, LARGEST = 1e-4, 1e7
"""Outside these a number is written with a power of ten."""
SYMBOLS = {"deg": "°"}
"""The signs of units whose names in files are words."""
ATTACHED = ("°",)
"""Units that follow their number without a space."""


def figure(value: float, significant: int = 3, *, zeros: bool = False) -> str:
    """A number with so many significant digits and commas between thousands; a dash where there is none.

    zeros : keep those at the end, which tell how well the number is known.
    """
    if not np.isfinite(value):
        return "–"
    if value == 0:
        return "0"
    if not SMALLEST <= abs(value) < LARGEST:
        return f"{value:{'#' if zeros else ''}.{significant}g}"
    text = f"{value:,.{max(0, significant - 1 - int(np.floor(np.log10(abs(value)))))}f}"
    return text.rstrip("0").rstrip(".") if "." in text and not zeros else text


def quantity(value: float, unit: str) -> str:
    """A number with its unit: "1,234 nT", "0.02°", "0.5" where there is none."""
    mark = symbol(unit)
    return f"{figure(value)}{mark if mark in ATTACHED else f' {mark}'}".rstrip()


def symbol(unit: str) -> str:
    """A unit's sign for readers."""
    return SYMBOLS.get(unit, unit)


def figures(values: Sequence[float] | Any, significant: int = 3) -> str:
    """Numbers for a sentence: one where all are the same, else every one of them."""
    texts = [figure(float(v), significant) for v in values]
    return texts[0] if len(set(texts)) == 1 else listed(texts)


def listed(texts: Sequence[str]) -> str:
    """ "a", "a and b", "a, b and c"."""
    return ", ".join(texts[:-1]) + f" and {texts[-1]}" if len(texts) > 1 else "".join(texts)


def counted(number: int, what: str, many: str = "") -> str:
    """ "1 gap", "2 gaps", "no gap"."""
    return f"no {what}" if number == 0 else f"1 {what}" if number == 1 else f"{number:,} {many or what + 's'}"


def all_of(number: int, what: str) -> str:
    """ "both runs", "all 3 runs"."""
    return f"both {what}" if number == 2 else f"all {number:,} {what}"


def duration(seconds: float) -> str:
    """A length of time in the unit that suits it."""
    for unit, size in (("d", 86_400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{figure(seconds / size)} {unit}"
    return f"{figure(1e3 * seconds)} ms" if 0 < seconds < 0.1 else f"{figure(seconds)} s"


def frequency(hertz: float) -> str:
    """A rate in Hz, or the time between two where it is slow."""
    return f"{figure(hertz, 4)} Hz" if hertz >= 0.2 else f"one in {duration(1 / hertz)}" if hertz > 0 else "0 Hz"


def short(value: Any) -> str:
    """A value for a terminal or a file, or a list of them in brackets: numbers to four digits."""
    if isinstance(value, list):
        return "(" + ", ".join(short(v) for v in value) + ")"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def digits(value: float, significant: int = 3) -> str:
    """A measured number on a page: its significant digits, thousands parted by a thin space."""
    return _typeset(figure(value, significant, zeros=True))


def plainly(value: float) -> str:
    """A given or counted number on a page: up to seven digits, no zeros at the end."""
    return _typeset(f"{value:,.7g}")


def _typeset(number: str) -> str:
    return number.replace(",", "\u2009").replace("-", "−")


def sentence(text: str) -> str:
    """A clause as a sentence of its own."""
    return f"{text[:1].upper()}{text[1:]}."


def words(name: str) -> str:
    """A name for readers."""
    return name.replace("_", " ")
