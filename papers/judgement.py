"""Judgement of a row: the verdict, the tolerance within which it stands, and the reason for that tolerance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from validation.text import figure

Verdict = Literal[
    "same number", "same order", "better", "another noise law", "holds", "does not hold", "not comparable"
]
SAME_SHARE = 0.1
"""Deviation from a printed number that is still the same number: one run scatters by as much."""
ORDER = 3.0
"""Factor on a printed number within which ours has the same order: conditions left open change as much."""
GOOD: tuple[Verdict, ...] = ("same number", "better", "holds")
"""Verdicts under which the printed figure or claim is confirmed."""
SCATTER = "one printed run among our seeds"
Values = float | Sequence[float] | NDArray[np.float64]


@dataclass(frozen=True)
class Judged:
    """Verdict, tolerance in words, and the reason for the tolerance."""

    verdict: Verdict
    tolerance: str
    reason: str

    @property
    def text(self) -> str:
        """Return tolerance and reason in one cell of a table."""
        return f"{self.tolerance}: {self.reason}"


def claim(holds: bool | np.bool, tolerance: str, reason: str) -> Judged:
    """Return the judgement of a claim in words: holds or does not hold."""
    return Judged("holds" if holds else "does not hold", tolerance, reason)


def incomparable(reason: str) -> Judged:
    """Return the judgement where the paper prints nothing to compare with."""
    return Judged("not comparable", "none", reason)


def number(ours: Values, printed: Values, reason: str = SCATTER) -> Judged:
    """Return whether ours is the printed number, has its order, or neither; of several numbers the worst decides."""
    factor = np.abs(np.log(np.abs(np.asarray(ours, dtype=float) / np.asarray(printed, dtype=float))))
    worst = float(np.exp(np.max(factor)))
    verdict: Verdict = "same number" if worst <= 1 + SAME_SHARE else "same order" if worst <= ORDER else "does not hold"
    return Judged(
        verdict, f"{100 * SAME_SHARE:.0f} %, order: a factor of {ORDER:g}; worst here {figure(worst)}", reason
    )


def error_size(seeds: NDArray[np.float64], printed: float, reason: str = SCATTER) -> Judged:
    """Return the judgement of a printed error by the 5 to 95 % range of our seeds: within, better below, else `number`.

    A printed error above the range is called better; one below the range is judged by our median, as any number.
    """
    low, middle, high = np.quantile(seeds, (0.05, 0.5, 0.95))
    if printed > high:
        return Judged("better", f"printed above our 95 % of {figure(high)}", reason)
    if printed >= low:
        return Judged("same number", f"printed within our 5 to 95 %, {figure(low)} to {figure(high)}", reason)
    return number(float(middle), printed, reason)
