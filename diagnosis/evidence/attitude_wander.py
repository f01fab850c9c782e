"""Noise model in which the attitude of navigation wanders: the error of the field comes and goes with the motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline
from diagnosis.library.candidates import attitude_turns
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array


def with_attitude_wander(coloured_baseline: ColouredBaseline, problem: LinearProblem) -> ColouredBaseline | None:
    """The coloured baseline with a noise model of sensor axes and of three attitude angles.

    None where the motion does not turn the sensor.
    """
    if not problem.turns:
        return None
    rows = coloured_baseline.rows
    turns = rows.bin(attitude_turns(problem))
    output_axes = turns / np.sqrt((turns**2).mean())
    together = replace(rows, base=_for_all(rows.base), output_axes=output_axes, common=True)
    return ColouredBaseline.in_rows(together, coloured_baseline.accepted_columns)


def attitude_wander_explains_more(candidate: CandidateFit, wander: ColouredBaseline | None, needed: float) -> bool:
    """Whether attitude wander is likelier than a candidate, and leaves the candidate less than the needed nats.

    On the sensor's axes a slow attitude error is modulated by the motion; no noise model of the axes alone describes
    the modulation.
    """
    if (
        wander is None
        or wander.hypothesis.log_likelihood < candidate.hypothesis.log_likelihood + wander.rows.policy.apart
    ):
        return False
    return wander.fit_candidate(candidate.evidence, candidate.columns, candidate.within).gain <= needed


def _for_all(base: Array) -> Array:
    """Base (n, q, p) with coefficients per output, as a base (n, q, q p) with coefficients shared by all outputs."""
    n, q, p = base.shape
    out = np.zeros((n, q, q, p))
    out[:, np.arange(q), np.arange(q)] = base
    return out.reshape(n, q, q * p)
