"""Samples after a start or a pause, in which a lagging measurement shows an unrecorded past."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from diagnosis.problem.linear import LinearProblem


def find_start_samples(problem: LinearProblem) -> NDArray[np.bool_]:
    """Mask (n,) of samples so soon after a start that a lagging measurement may show the field before the start.

    Two samples of this kind, in a recording that begins in motion, would outweigh the remaining samples in the test of
    an effect's form. With attitude only, and at most a small share of the samples.
    """
    policy, time_s = problem.policy, problem.recording.time_s
    after_start = np.zeros(len(time_s), dtype=bool)
    if problem.mode != "vector" or problem.still or problem.relative:
        return after_start
    most = policy.start_share * len(time_s) * problem.state.interval_s / len(problem.sections)
    for section in problem.sections:
        after_start[section] = time_s[section] - time_s[section.start] < min(policy.start_s, most)
    return after_start
