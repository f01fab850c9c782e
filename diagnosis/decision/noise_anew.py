"""The noise of a sample estimated again once effects are accepted that change from sample to sample."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from diagnosis.decision.joint_iron import select_jointly
from diagnosis.decision.selection import Progress, Selection
from diagnosis.problem.linear import LinearProblem, pauses_after, sample_noise
from scenarios.arrays import Array


def select_in_own_noise(selection: Selection, say: Progress = lambda what: None) -> Selection:
    """Select again with the noise that the accepted effects leave, where it is smaller than taken before.

    A current that is switched counts as noise of the sample until its effect is accepted. Vector mode only: by strength
    alone the noise is estimated anew with the iron.
    """
    problem = selection.end.problem
    if problem.mode != "vector" or not selection.accepted:
        return selection
    left_nT = noise_left_nT(problem, selection.end.residual())
    smaller = left_nT * problem.policy.larger < problem.sigma_nT
    if not smaller.any() or not np.isfinite(left_nT).all():
        return selection
    say("the noise anew")
    target = problem.target * (problem.sigma_nT / left_nT)
    again = select_jointly(replace(problem, target=target, sigma_nT=left_nT), selection.without, say)
    return again if again.accepted else selection


def noise_left_nT(problem: LinearProblem, residual: Array) -> Array:
    """White noise (q,) in nT of the used samples of a residual (n, q), given in units of the problem's noise."""
    used = problem.usable > 0
    return sample_noise(residual[used] * problem.sigma_nT, pauses_after(problem.state.time_s[used], problem.policy))
