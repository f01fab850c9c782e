"""A rest in which navigation's attitude wanders: what that turns the field by comes and goes with the motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline
from diagnosis.library.candidates import Candidate
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects.earth import AttitudeMisalignment


def beside_a_wander(beside: ColouredBaseline, problem: LinearProblem) -> ColouredBaseline | None:
    """The same rows beside a rest of the sensor's axes and of three turns of the attitude.

    None where the motion shows no turns.
    """
    if not problem.turns:
        return None
    rows = beside.rows
    turns = rows.taken(Candidate(AttitudeMisalignment).columns(problem))
    sight = turns / np.sqrt((turns**2).mean())
    together = replace(rows, base=_for_all(rows.base), sight=sight, common=True)
    return ColouredBaseline.in_rows(together, beside.inside)


def a_wander_does_better(one: CandidateFit, wander: ColouredBaseline | None, needed: float) -> bool:
    """Whether a wander is likelier than a candidate beside a rest of its own, which gains too little beside the wander.

    Of slow errors of the attitude a sensor's axes see what the motion makes of them, which no rest of the axes is.
    """
    if wander is None or wander.poorer.whole < one.hypothesis.whole + wander.rows.policy.apart:
        return False
    return wander.standing(one.evidence, one.columns, one.within).gain <= needed


def _for_all(base: Array) -> Array:
    """The base (n, q, p) of outputs with coefficients of their own as (n, q, q p) with coefficients in common."""
    n, q, p = base.shape
    out = np.zeros((n, q, q, p))
    out[:, np.arange(q), np.arange(q)] = base
    return out.reshape(n, q, q * p)
