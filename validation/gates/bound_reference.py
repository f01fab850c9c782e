"""The Cramer-Rao bound as the reference of a gate: the limit is a multiple of the bound in each run."""

from __future__ import annotations

import math
from dataclasses import dataclass

from scenarios.errors import InputError
from validation.bound.ratio import knowledge_of
from validation.bound.runs import RunBounds
from validation.comparison.design import Design
from validation.gates.gate_file import Gate


@dataclass(frozen=True)
class BoundReference:
    """Lower bound on the rms of a score, by column, for any method with equal knowledge (a word of KNOWLEDGE)."""

    bounds: RunBounds
    knowledge: str
    column: str

    @classmethod
    def of(cls, gate: Gate, calibrator: str, design: Design) -> BoundReference:
        """Return the bound of a gate's score and calibrator; InputError where the first run has no known bound."""
        scenario = design.points[-1].scenario
        entry = next((one for one in design.candidates if one.name == calibrator.partition("@")[0]), None)
        knowledge = None
        if entry is not None:
            knowledge = knowledge_of(calibrator, entry.needs, attitude_free=entry.attitude_free, eddy=entry.eddy)
        bounds = RunBounds(scenario, design.seed, frozenset({knowledge} if knowledge else ()))
        found = cls(bounds, knowledge or "", gate.score_definition.column)
        if knowledge is None or not 0 < found.in_run(0) < math.inf:
            what = f"no bound is known on {gate.score_definition.name} of {calibrator} in {scenario.name}"
            raise InputError(what, do="name a calibrator as the reference, or give a limit")
        return found

    def in_run(self, run: int) -> float:
        """Return the bound in a run; infinite where no bound is known."""
        return self.bounds.of(run).get((self.knowledge, self.column), math.inf)
