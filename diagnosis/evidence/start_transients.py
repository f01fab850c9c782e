"""Samples after a start or a pause, where what is late still shows a field that nobody logged."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from diagnosis.problem.linear import LinearProblem


def unknown_past(problem: LinearProblem) -> NDArray[np.bool_]:
    """Samples (n,) so soon after a start that a late measurement may show the field before it.

    Two such samples of a log that begins in motion weigh more than the forms of all its others. Only beside an
    attitude, and no more than a small share of the samples.
    """
    policy, time_s = problem.policy, problem.recording.time_s
    first = np.zeros(len(time_s), dtype=bool)
    if problem.mode != "vector" or problem.still or problem.relative:
        return first
    most = policy.start_share * len(time_s) * problem.state.interval_s / len(problem.stretches)
    for one in problem.stretches:
        first[one] = time_s[one] - time_s[one.start] < min(policy.start_s, most)
    return first
