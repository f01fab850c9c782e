"""The least error that a gate's limit is a multiple of, in each run by itself."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from sim.reuse import alike
from sim.scenario import Scenario
from sim.simulate import plan
from validation.bound.ratio import least_in


@dataclass(frozen=True)
class Least:
    """The least rms of a score, by its column, that any method reaches which is told as much (a word of KNOWLEDGE).

    Runs that differ in noise alone have one.
    """

    scenario: Scenario
    seed: int
    knowledge: str
    column: str
    _found: dict[str, float] = field(default_factory=dict, repr=False, compare=False)

    def of(self, run: int) -> float:
        """In a run; infinite where there is no limit to it, or none is known."""
        ready = plan(self.scenario, run, self.seed)
        key = alike(ready)
        if key not in self._found:
            least = least_in(ready, {self.knowledge})
            self._found[key] = least.get((self.knowledge, self.column), math.inf)
        return self._found[key]
