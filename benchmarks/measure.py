"""CPU time of interleaved calls, and the row that a benchmark prints."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass

Call = Callable[[], object]


@dataclass(frozen=True)
class Row:
    """One measured figure against its limit; `least`: the limit is a lower one."""

    what: str
    value: float
    limit: float
    least: bool
    note: str

    @property
    def holds(self) -> bool:
        """Whether the figure keeps to its limit."""
        return self.value >= self.limit if self.least else self.value <= self.limit


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
