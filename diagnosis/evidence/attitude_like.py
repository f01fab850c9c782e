"""A field that an error of the attitude makes as well: across the field it has all that it turns, along it nothing."""

from __future__ import annotations

import numpy as np

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.candidate_test import gains_along_the_field
from diagnosis.library.candidates import Candidate
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.effects.channels import HIGHEST

TURNS = {
    name for effect in EFFECTS if effect.traits.attitude_error for name in (effect.name, effect.traits.equivalent_to)
}
"""Effects that are an error of the attitude, and those that do the same on every motion."""


def an_attitude_does_as_well(ground: Baseline, with_it: Baseline, one: Candidate) -> bool:
    """Whether a turn that changes smoothly in the run explains as much of what a ground leaves as a field of its own.

    The turn's columns times ``x^j``, x the time from 0 to 1, against the field's, on held-out segments. None is asked
    where the field shows along the earth's, or without attitude. with_it : the ground with the field in.
    """
    problem = ground.problem
    if not one.effect.traits.field_source or problem.mode != "vector" or problem.relative:
        return False
    if gains_along_the_field(ground, with_it, one.tried):
        return False
    turned = ground.evidence_of(_turning(problem))
    return turned > ground.evidence_of(one.columns(problem)) - problem.policy.apart


def _turning(problem: LinearProblem) -> Array:
    """Columns (n, q, k) of constant turns, and of turns that grow with the powers of time."""
    time_s = problem.state.time_s
    x = (time_s - time_s[0]) / (time_s[-1] - time_s[0])
    turns = [Candidate(effect).columns(problem) for effect in EFFECTS if effect.traits.attitude_error]
    return np.concatenate([turn * (x**j)[:, None, None] for j in range(HIGHEST + 1) for turn in turns], axis=2)
