"""Wrong values that come some in a row: far from what is about them, for a few samples, and back."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from sim.state import Array
from validation.diagnosis.problem.linear import LinearProblem

Mask = NDArray[np.bool_]


def highest_of_bursts(problem: LinearProblem, left_nT: Array) -> Mask:
    """The highest value (n, 3) of every burst in what the base leaves (n, 3); with attitude only.

    A burst lasts two samples to `most_burst`, each `burst_sigma` from the median about it, where the rest is quiet: a
    body that is passed, or a base that does not fit, is none.
    """
    found = np.zeros(left_nT.shape, bool)
    policy = problem.policy
    settled = (np.median(np.abs(left_nT), axis=0) < policy.quiet_sigma * problem.sigma_nT).all()
    if problem.mode != "vector" or problem.still or not settled:
        return found
    size = (policy.burst_median, 1)
    off = np.abs(left_nT - median_filter(left_nT, size=size, mode="nearest")) / problem.sigma_nT
    quiet = median_filter(off, size=size, mode="nearest") < policy.quiet_sigma
    for axis, far in enumerate(((off > policy.burst_sigma) & quiet).T):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], far.astype(np.int8), [0]])))
        for first, end in edges.reshape(-1, 2):
            if 2 <= end - first <= policy.most_burst:
                found[first + int(np.argmax(off[first:end, axis])), axis] = True
    return found
