"""Bounds of single runs of a scenario."""

from __future__ import annotations

from dataclasses import dataclass, field

from sim.motion_cache import MotionCache, run_key
from sim.scenario import Scenario
from sim.simulation import plan
from validation.bound.ratio import LeastErrors, least_errors_in


@dataclass(frozen=True)
class RunBounds:
    """Least rms of scores over trials of a single run, by knowledge and column of the score.

    knowledges : keys of KNOWLEDGE. Runs that differ only in noise have equal bounds; runs with equal physics are
    simulated once.
    """

    scenario: Scenario
    seed: int
    knowledges: frozenset[str]
    _flights: MotionCache = field(default_factory=MotionCache, repr=False, compare=False)
    _found: dict[str, LeastErrors] = field(default_factory=dict, repr=False, compare=False)

    def of(self, run: int) -> LeastErrors:
        """Return the bounds of a run; empty without noise, and if the vehicle cannot perform the motion."""
        if not self.knowledges:
            return {}
        ready = plan(self.scenario, run, self.seed)
        key = run_key(ready)
        if key not in self._found:
            self._found[key] = least_errors_in(ready, set(self.knowledges), self._flights)
        return self._found[key]
