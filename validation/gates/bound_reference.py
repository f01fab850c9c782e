"""The least error that a gate's limit is a multiple of, in each run by itself."""

from __future__ import annotations

import math
from dataclasses import dataclass

from validation.bound.runs import RunBounds


@dataclass(frozen=True)
class BoundReference:
    """The least rms of a score, by its column, that any method reaches which is told as much (a word of KNOWLEDGE)."""

    bounds: RunBounds
    knowledge: str
    column: str

    def of(self, run: int) -> float:
        """In a run; infinite where there is no limit to it, or none is known."""
        return self.bounds.of(run).get((self.knowledge, self.column), math.inf)
