"""Base of the reproductions: row of a printed figure, reproduction of a paper, tasks over seeds."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from papers.judgement import GOOD, Judged, Verdict
from reports.plots.style import Figure
from sim.pool import LocalTasks, Tasks

Progress = Callable[[int, int], object]
"""Called with (pieces done, pieces in all)."""
Work = Sequence[tuple[Callable[[Any], Any], Sequence[Any]]]
"""Module-level functions, each with a sequence of arguments."""
_cluster: ContextVar[Tasks | None] = ContextVar("_cluster", default=None)


@dataclass(frozen=True)
class PaperRow:
    """A printed figure or claim of a paper and the bench's own.

    what: quantity with unit and conditions; paper, ours: text with units, ours with spread over the seeds; judged:
    verdict with its tolerance and reason; note: evidence, and the explanation of a difference.
    """

    what: str
    paper: str
    ours: str
    judged: Judged
    note: str = ""

    @property
    def verdict(self) -> Verdict:
        """Return the verdict."""
        return self.judged.verdict

    @property
    def tolerance(self) -> str:
        """Return the tolerance of the verdict and its reason."""
        return self.judged.text

    @property
    def holds(self) -> bool:
        """Return whether our figure is at least as good as the printed figure, or the claim is confirmed."""
        return self.verdict in GOOD


def spread_text(
    values: Sequence[float] | NDArray[np.float64], unit: str = "", *, significant: int = 3, decimals: int | None = None
) -> str:
    """Return median, unit, and 5 to 95 % of a figure over the seeds, with fixed decimals if given."""
    form = f".{significant}g" if decimals is None else f".{decimals}f"
    low, middle, high = (format(value, form) for value in np.quantile(values, (0.05, 0.5, 0.95)))
    return f"{middle} {unit}".rstrip() + f" ({low} to {high})"


@dataclass(frozen=True)
class Findings:
    """Rows and figures of a reproduction."""

    rows: tuple[PaperRow, ...]
    figures: dict[str, Callable[[], Figure]] = field(default_factory=dict)


@dataclass(frozen=True)
class Reproduction(ABC):
    """A paper's scenario, settings and figures; a subclass writes `run`.

    seeds: number of independent repetitions behind every spread.
    """

    seeds: int = 50
    key: ClassVar[str]
    title: ClassVar[str]

    @abstractmethod
    def run(self, jobs: int = 1, progress: Progress = lambda done, total: None) -> Findings:
        """Repeat the paper's experiments over seeds 0 to seeds - 1; `jobs` processes never change a figure."""


def run_tasks(work: Work, jobs: int, progress: Progress) -> tuple[list[Any], ...]:
    """Return each function's results over its items in order, for any number of processes."""
    calls = [(k, i, function, item) for k, (function, items) in enumerate(work) for i, item in enumerate(items)]
    results: tuple[list[Any], ...] = tuple([None] * len(items) for _, items in work)
    found = (_cluster.get() or LocalTasks(jobs)).map(_called, calls)
    for done, ((k, i, _, _), result) in enumerate(found, start=1):
        results[k][i] = result
        progress(done, len(calls))
    return results


@contextmanager
def computed_on(cluster: Tasks | None) -> Iterator[None]:
    """Within, `run_tasks` computes on a cluster in place of this machine's processes; None changes nothing."""
    token = _cluster.set(cluster)
    try:
        yield
    finally:
        _cluster.reset(token)


def _called(call: tuple[int, int, Callable[[Any], Any], Any]) -> Any:
    return call[2](call[3])
