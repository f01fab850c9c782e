"""A paper's figures beside ours: the row, the reproduction, and what they need from each other."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar, Literal

from validation.plots.style import Figure

Verdict = Literal["holds", "better", "does not hold", "not comparable"]
Progress = Callable[[int, int], object]
"""Told (pieces done, pieces in all)."""


@dataclass(frozen=True)
class Row:
    """One printed figure or claim of a paper beside ours.

    what: the quantity with its unit and conditions; paper, ours: as text with units, ours with its spread over the
    seeds; verdict; note: the evidence, and what explains a difference.
    """

    what: str
    paper: str
    ours: str
    verdict: Verdict
    note: str = ""

    @property
    def holds(self) -> bool:
        """Whether our figure is at least as good as the printed one, or the claim is confirmed."""
        return self.verdict in ("holds", "better")


@dataclass(frozen=True)
class Findings:
    """What one reproduction gave: rows, and pictures like the paper's by name."""

    rows: tuple[Row, ...]
    figures: dict[str, Callable[[], Figure]] = field(default_factory=dict)


@dataclass(frozen=True)
class Reproduction(ABC):
    """One paper: a scenario, its settings and its figures; a subclass writes `run`.

    seeds: number of independent repetitions behind every spread.
    """

    seeds: int = 50
    key: ClassVar[str]
    title: ClassVar[str]

    @abstractmethod
    def run(self, jobs: int = 1, progress: Progress = lambda done, total: None) -> Findings:
        """Repeat the paper's experiments over seeds 0 to seeds - 1; `jobs` processes never change a figure."""
