"""What an inspection says: one value, its unit and one plain sentence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

Level = Literal["ok", "note", "warning"]


@dataclass(frozen=True)
class Finding:
    """A value (number, list, mapping or text) with its unit and a sentence; `level` says how much it matters.

    sensor : number of the sensor of an array that it is about, None for the recording as a whole.
    """

    section: str
    name: str
    value: Any
    unit: str
    text: str
    level: Level = "ok"
    sensor: int | None = None


def figure(value: float, significant: int = 3) -> str:
    """A number for a sentence, with commas between thousands; "–" where there is none."""
    if not np.isfinite(value):
        return "–"
    if value == 0 or not 1e-4 <= abs(value) < 1e7:
        return f"{value:.{significant}g}"
    decimals = max(0, significant - 1 - int(np.floor(np.log10(abs(value)))))
    text = f"{value:,.{decimals}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def figures(values: Sequence[float] | Any, significant: int = 3) -> str:
    """Numbers for a sentence: one where all are the same, else every one of them."""
    texts = [figure(float(v), significant) for v in values]
    return texts[0] if len(set(texts)) == 1 else ", ".join(texts[:-1]) + f" and {texts[-1]}"


def counted(number: int, what: str, many: str = "") -> str:
    """ "1 gap", "2 gaps", "no gap"."""
    return f"no {what}" if number == 0 else f"1 {what}" if number == 1 else f"{number:,} {many or what + 's'}"


def duration(seconds: float) -> str:
    """A length of time in the unit that suits it."""
    for unit, size in (("d", 86_400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{figure(seconds / size)} {unit}"
    return f"{figure(1e3 * seconds)} ms" if 0 < seconds < 0.1 else f"{figure(seconds)} s"


def frequency(hertz: float) -> str:
    """A rate in Hz, or the time between two where it is slow."""
    return f"{figure(hertz, 4)} Hz" if hertz >= 0.2 else f"one in {duration(1 / hertz)}" if hertz > 0 else "0 Hz"
