"""Bursts: wrong values in a few consecutive samples, far from the median of their neighbourhood."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from diagnosis.evidence.along_field import along_field
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem, pauses_after
from scenarios.arrays import Array

Mask = NDArray[np.bool_]


def find_burst_peaks(problem: LinearProblem, left_nT: Array) -> Mask:
    """Mask (n, 3) of the highest value of every burst in the base's residual (n, 3), or in the strength.

    A burst lasts 2 to `most_burst` samples, each `never_sigma` from the local median while the median of the deviations
    is small: a passed body, or a base that does not fit, is no burst. A deviation of the strength, which no turn
    causes, may last one sample unless next to a pause. Without attitude the affected axis is the axis farthest from the
    line between the ends of the burst.
    """
    found, policy = np.zeros(left_nT.shape, bool), problem.policy
    by_strength = problem.mode == "strength"
    seen_nT = problem.off_strength_nT if by_strength else left_nT
    sigma_nT = problem.sigma_nT[: seen_nT.shape[1]]
    settled = (np.median(np.abs(seen_nT), axis=0) < policy.somewhat_larger * sigma_nT).all()
    if problem.still or not settled:
        return found
    single = np.ones(len(found), bool) if by_strength else _off_strength(problem, left_nT)
    gaps = pauses_after(problem.state.time_s, policy)
    single[np.intersect1d(gaps, gaps + 1)] = False
    for column, first, end, at in _bursts(seen_nT / sigma_nT, policy):
        if end - first <= policy.most_burst and (end - first > 1 or single[at]):
            found[at, _farthest(problem.recording.mag_nT, first, end, at) if by_strength else column] = True
    return found


def _off_strength(problem: LinearProblem, left_nT: Array) -> Mask:
    """Mask (n,) of outliers of the strength in the base's residual (n, 3); empty without a compared attitude."""
    if not problem.compares_across:
        return np.zeros(len(left_nT), bool)
    seen, _ = along_field(problem, left_nT / problem.sigma_nT)
    return _far(seen[:, None], problem.policy)[0][:, 0]


def _far(seen: Array, policy: Policy) -> tuple[Mask, Array]:
    """Outliers (n, q) among quiet neighbours, and the distance of each value from the local median."""
    size = (policy.burst_median, 1)
    off = np.abs(seen - median_filter(seen, size=size, mode="nearest"))
    quiet = median_filter(off, size=size, mode="nearest") < policy.somewhat_larger
    return (off > policy.never_sigma) & quiet, off


def _bursts(seen: Array, policy: Policy) -> Iterator[tuple[int, int, int, int]]:
    """Column, first sample, end and highest sample of every run of outliers in (n, q)."""
    stands_out, off = _far(seen, policy)
    for column, far in enumerate(stands_out.T):
        for first, end in runs(far):
            yield column, int(first), int(end), int(first) + int(np.argmax(off[first:end, column]))


def runs(samples: Mask) -> NDArray[np.intp]:
    """First sample and end (m, 2) of each run of true samples (n,)."""
    return np.flatnonzero(np.diff(np.concatenate([[0], samples.astype(np.int8), [0]]))).reshape(-1, 2)


def _farthest(mag_nT: Array, first: int, end: int, at: int) -> int:
    """Axis of values (n, 3) that is farthest, at sample `at`, from the line across samples `first` to `end`."""
    ends = np.clip([first - 1, end], 0, len(mag_nT) - 1)
    share = (at - ends[0]) / max(ends[1] - ends[0], 1)
    line = mag_nT[ends[0]] + share * (mag_nT[ends[1]] - mag_nT[ends[0]])
    return int(np.argmax(np.abs(mag_nT[at] - line)))
