"""Wrong values that come some in a row: far from what is about them, for a few samples, and back."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem, pauses_after
from scenarios.arrays import Array

Mask = NDArray[np.bool_]


def highest_of_bursts(problem: LinearProblem, left_nT: Array) -> Mask:
    """The highest value (n, 3) of every burst in what the base leaves (n, 3), or in the strength without attitude.

    A burst lasts two samples to `most_burst`, each `burst_sigma` from the median about it, where the rest is quiet: a
    body that is passed, or a base that does not fit, is none. One that the strength shows, where no turn does, may last
    one sample, not between pauses; without attitude the axis is the one that is farthest from the line across it.
    """
    found, policy = np.zeros(left_nT.shape, bool), problem.policy
    by_strength = problem.mode == "strength"
    seen_nT = problem.off_strength_nT if by_strength else left_nT
    sigma_nT = problem.sigma_nT[: seen_nT.shape[1]]
    settled = (np.median(np.abs(seen_nT), axis=0) < policy.quiet_sigma * sigma_nT).all()
    if problem.still or not settled:
        return found
    single = np.ones(len(found), bool) if by_strength else _off_strength(problem, left_nT)
    gaps = pauses_after(problem.state.time_s, policy)
    single[np.intersect1d(gaps, gaps + 1)] = False
    for column, first, end, at in _runs(seen_nT / sigma_nT, policy):
        if end - first <= policy.most_burst and (end - first > 1 or single[at]):
            found[at, _farthest(problem.recording.mag_nT, first, end, at) if by_strength else column] = True
    return found


def _off_strength(problem: LinearProblem, left_nT: Array) -> Mask:
    """Samples (n,) whose strength stands out of what the base leaves (n, 3); none where no attitude is compared."""
    if not problem.sees_across:
        return np.zeros(len(left_nT), bool)
    along = problem.sees_along
    seen = (along * left_nT).sum(axis=1) / np.linalg.norm(along * problem.sigma_nT, axis=1)
    return _far(seen[:, None], problem.policy)[0][:, 0]


def _far(seen: Array, policy: Policy) -> tuple[Mask, Array]:
    """Where (n, q) stands out from a quiet rest, and how far it is from the median about it."""
    size = (policy.burst_median, 1)
    off = np.abs(seen - median_filter(seen, size=size, mode="nearest"))
    quiet = median_filter(off, size=size, mode="nearest") < policy.quiet_sigma
    return (off > policy.burst_sigma) & quiet, off


def _runs(seen: Array, policy: Policy) -> Iterator[tuple[int, int, int, int]]:
    """Column, first sample, end and highest sample of every run of (n, q) that stands out from a quiet rest."""
    stands_out, off = _far(seen, policy)
    for column, far in enumerate(stands_out.T):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], far.astype(np.int8), [0]])))
        for first, end in edges.reshape(-1, 2):
            yield column, int(first), int(end), int(first) + int(np.argmax(off[first:end, column]))


def _farthest(mag_nT: Array, first: int, end: int, at: int) -> int:
    """The axis of values (n, 3) that is farthest at a sample from the line across samples `first` to `end`."""
    ends = np.clip([first - 1, end], 0, len(mag_nT) - 1)
    share = (at - ends[0]) / max(ends[1] - ends[0], 1)
    line = mag_nT[ends[0]] + share * (mag_nT[ends[1]] - mag_nT[ends[0]])
    return int(np.argmax(np.abs(mag_nT[at] - line)))
