"""Field effects that a slowly changing attitude error, which acts across the field only, explains as well."""

from __future__ import annotations

import numpy as np

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.candidate_test import explains_along_field
from diagnosis.library.candidates import Candidate, attitude_turns
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.effects.channels import HIGHEST

TURNS = {
    name for effect in EFFECTS if effect.traits.attitude_error for name in (effect.name, effect.traits.equivalent_to)
}
"""Names of the attitude errors, and of the effects equal to them on every motion."""


def attitude_explains_as_much(baseline: Baseline, with_it: Baseline, candidate: Candidate) -> bool:
    """Whether a smooth attitude error explains as much of the baseline's residual as a candidate field.

    Columns ``T x^j``, T the columns of a small turn and x the time from 0 to 1, against the candidate's columns, on
    held-out segments. False without attitude, for candidates without a field of their own, and for candidates that gain
    along the Earth's field. with_it : the baseline with the candidate accepted.
    """
    problem = baseline.problem
    if not candidate.effect.traits.field_source or problem.mode != "vector" or problem.relative:
        return False
    if explains_along_field(baseline, with_it, candidate.tried):
        return False
    turned = baseline.evidence_of(_turning(problem))
    return turned > baseline.evidence_of(candidate.columns(problem)) - problem.policy.apart


def _turning(problem: LinearProblem) -> Array:
    """Columns (n, q, k) of turns that are constant or grow with a power of time."""
    time_s = problem.state.time_s
    x = (time_s - time_s[0]) / (time_s[-1] - time_s[0])
    turns = attitude_turns(problem)
    return np.concatenate([turns * (x**j)[:, None, None] for j in range(HIGHEST + 1)], axis=2)
