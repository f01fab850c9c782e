"""The bound in each run of a scenario by itself."""

from __future__ import annotations

from dataclasses import dataclass, field

from sim.motion_cache import MotionCache, run_key
from sim.scenario import Scenario
from sim.simulation import plan
from validation.bound.ratio import Leasts, least_in


@dataclass(frozen=True)
class RunBounds:
    """The least rms of scores over trials of one and the same run, by what is known and the score's column.

    knowledges : words of KNOWLEDGE. Runs that differ in noise alone have one bound, and runs that share their physics
    are flown once.
    """

    scenario: Scenario
    seed: int
    knowledges: frozenset[str]
    _flights: MotionCache = field(default_factory=MotionCache, repr=False, compare=False)
    _found: dict[str, Leasts] = field(default_factory=dict, repr=False, compare=False)

    def of(self, run: int) -> Leasts:
        """In a run; empty where there is no bound: without noise, or where the vehicle cannot do the motion."""
        if not self.knowledges:
            return {}
        ready = plan(self.scenario, run, self.seed)
        key = run_key(ready)
        if key not in self._found:
            self._found[key] = least_in(ready, set(self.knowledges), self._flights)
        return self._found[key]
