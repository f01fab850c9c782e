"""CPU time of interleaved calls, and the row that a benchmark prints."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass

Call = Callable[[], object]


@dataclass(frozen=True)
class Row:
    """One measured figure against its limit; `least`: the limit is a lower one; without a value it was skipped."""

    what: str
    value: float | None
    limit: float
    least: bool
    note: str

    @property
    def verdict(self) -> str:
        """Whether the figure keeps to its limit: holds, MISSED, or skipped."""
        if self.value is None:
            return "skipped"
        kept = self.value >= self.limit if self.least else self.value <= self.limit
        return "holds" if kept else "MISSED"

    def text(self, width: int) -> str:
        """The row as a line, what was measured `width` wide."""
        value = "       –" if self.value is None else f"{self.value:8.3f}"
        return f"{self.what:{width}}  {value}  limit {self.limit:g}  {self.verdict}  {self.note}"


def cpu_s(call: Call) -> float:
    """CPU seconds of this process in one call."""
    start = time.process_time()
    call()
    return time.process_time() - start


def paired_ratio(numerator: Call, denominator: Call, pairs: int = 5) -> tuple[float, float, float]:
    """Median over pairs of (numerator / denominator), after one warm-up; with the median seconds of each."""
    numerator(), denominator()
    times = [(cpu_s(numerator), cpu_s(denominator)) for _ in range(pairs)]
    top, bottom = zip(*times, strict=True)
    return statistics.median(a / b for a, b in times), statistics.median(top), statistics.median(bottom)
