"""Direct evidence, without a fit: rounding, full scale, repeated and wrong values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import median_filter

from diagnosis.evidence.along_field import along_field
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.motion import held, pauses_after, repeated
from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.effects import of_sign
from sim.effects.base import Effect
from sim.effects.traits import Sign
from validation.signals.amplitude import rms
from validation.signals.faults import pile_up, repeats, spikes
from validation.signals.lattice import Lattice, find_lattice

Mask = NDArray[np.bool_]
Lattices = tuple[Lattice | None, ...]


@dataclass(frozen=True)
class DirectFinding:
    """An effect identified from the raw values, and the mask (n,) of samples invalid because of the effect.

    stated : whether the model states the effect too; its samples are invalid all the same.
    """

    effect: Effect
    samples: Mask
    stated: bool = False


def direct_evidence(problem: LinearProblem, without: frozenset[str] = frozenset()) -> list[DirectFinding]:
    """Rounding, full scale, repeated values and spikes of a recording, except effects named in `without`."""
    lattices = tuple(find_lattice(axis) for axis in problem.recording.mag_nT.T)
    clipped = _clipped(problem, lattices)
    found = [_rounded(problem, lattices), clipped, _held(problem)]
    no_values = [repeated(problem.recording.mag_nT), problem.usable == 0]
    gone = np.logical_or.reduce([*no_values, *(finding.samples for finding in found if finding is not None)])
    if clipped is None:  # a clipped stretch has no noise of its own to measure a spike by
        found.append(_wrong_values(problem, lattices, _with_neighbours(problem, gone)))
    return [finding for finding in found if finding is not None and finding.effect.name not in without]


def held_rows(problem: LinearProblem) -> Mask:
    """Mask (n,) of rows that repeat the row before because no new value was measured."""
    mag_nT = problem.recording.mag_nT
    residual = problem.off_strength_nT if problem.mode == "strength" else mag_nT - problem.clean_nT
    return held(mag_nT, residual, problem.policy)


def find_start_samples(problem: LinearProblem) -> Mask:
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


def _rounded(problem: LinearProblem, lattices: Lattices) -> DirectFinding | None:
    """Values on a lattice with a step other than the model's."""
    steps = [lattice.step for lattice in lattices if lattice is not None and not lattice.floating]
    if len(steps) < len(lattices):
        return None
    policy, step = problem.policy, float(np.median(steps))
    given = [0.0, *_stated(problem, "lattice")][-1]
    if step < policy.trace * problem.sigma_nT.min() or abs(step - given) < policy.same_step * step:
        return None
    return _finding("lattice", np.zeros(len(problem.recording)), step)


def _clipped(problem: LinearProblem, lattices: Lattices) -> DirectFinding | None:
    """Values that pile up at a full scale."""
    mag = problem.recording.mag_nT
    piles = pile_up(mag, lattices)
    if not piles:
        return None
    level = float(np.median([abs(pile.level) for pile in piles]))
    stated = abs(level - [0.0, *_stated(problem, "full_scale")][-1]) < problem.policy.same_full_scale * level
    return _finding("full_scale", np.any(np.abs(mag) >= level * (1 - 1e-9), axis=1), level, stated=stated)


def _held(problem: LinearProblem) -> DirectFinding | None:
    """Repeated rows, unless the model has dropouts.

    Of all repeated rows the held ones alone where these come at random: rounding repeats rows too, and a slower
    sensor's come evenly.
    """
    found, samples, policy = repeats(problem.recording.mag_nT), repeated(problem.recording.mag_nT), problem.policy
    gaps = runs(held_rows(problem))
    lengths, intervals = np.diff(gaps, axis=1)[:, 0], np.diff(gaps[:, 0])
    if len(gaps) < policy.least_spikes or intervals.std() < policy.half * intervals.mean():
        lengths = np.array([rows - 1 for _, rows in found.frozen])
    if not len(lengths) or found.hold > 1 or _stated(problem, "repeats"):
        return None
    number, length = _dropout_law(lengths)
    work_s = np.count_nonzero(~samples) * problem.state.interval_s
    return _finding("repeats", samples, number / work_s, length * problem.state.interval_s)


def _dropout_law(lengths: NDArray[Any]) -> tuple[float, float]:
    """Number of gaps and their mean length in sample intervals, from the repeated rows (m,) of each gap that is seen.

    A gap of exponential length d repeats k rows with a probability that falls by ``exp(-1 / d)`` a row, and none with
    ``1 - d (1 - exp(-1 / d))``. Gaps of one length are counted as they are.
    """
    mean = float(lengths.mean())
    if np.ptp(lengths) == 0:
        return len(lengths), mean
    d = -1.0 / np.log(1.0 - 1.0 / mean)
    return float(len(lengths) / (d * -np.expm1(-1.0 / d))), float(d)


def _wrong_values(problem: LinearProblem, lattices: Lattices, beside: Mask) -> DirectFinding | None:
    """Isolated outliers and bursts, unless a neighbour is repeated, clipped or a current's spike."""
    policy, residual = problem.policy, problem.recording.mag_nT - problem.clean_nT
    switched = np.asarray(spikes(problem.state.current_A).any(axis=1), dtype=np.bool_)
    found = _isolated(problem, lattices, residual) | find_burst_peaks(problem, residual)
    where: Mask = np.asarray(found & ~(beside | _with_neighbours(problem, switched))[:, None], dtype=np.bool_)
    single: Mask = np.asarray(where.any(axis=1))
    if np.count_nonzero(where) < policy.least_spikes or _across_the_field(problem, residual, single):
        return None
    far, peaks = _far_runs(problem, residual, beside)
    if problem.mode == "vector" and np.count_nonzero(peaks) >= policy.least_spikes:
        where = peaks  # the smaller ones too: their law is known by more of them
    sizes_nT = np.abs(residual - np.median(residual, axis=0))[where]
    rate_hz, mean_nT = _spike_law(sizes_nT, len(residual) * problem.state.interval_s, policy.quarter)
    return _finding("outliers", single | far, rate_hz, mean_nT, stated=bool(_stated(problem, "outliers")))


def _far_runs(problem: LinearProblem, residual: Array, beside: Mask) -> tuple[Mask, Mask]:
    """Mask (n,) of short runs far from a quiet residual (n, 3), or strength, and mask (n, q) of their high peaks.

    A body beside the path, or a base that does not fit, lasts longer. Samples (n,) `beside` are left out.
    """
    policy = problem.policy
    seen = np.abs(problem.target[:, :1] if problem.mode == "strength" else residual / problem.sigma_nT)
    far, peaks = np.zeros(len(seen), np.bool_), np.zeros(seen.shape, np.bool_)
    if not _is_quiet(seen, policy):
        return far, peaks
    for first, end in runs(np.asarray((seen > policy.far_sigma).any(axis=1))):
        far[first:end] = end - first <= policy.most_burst
    far &= ~beside
    for first, end in runs(far):
        sample, axis = np.unravel_index(np.argmax(seen[first:end]), seen[first:end].shape)
        peaks[first + sample, axis] = seen[first + sample, axis] > policy.never_sigma
    return far, peaks


def _isolated(problem: LinearProblem, lattices: Lattices, residual: Array) -> Mask:
    """Isolated outliers (n, 3), in the raw values and in the base's residual (n, 3): a fast turn is no spike.

    Where only the strength is known the strength must deviate; deviations across the field do not count.
    """
    steps = np.array([0.0 if lattice is None else lattice.step for lattice in lattices])
    gaps = pauses_after(problem.state.time_s, problem.policy)
    raw = spikes(problem.recording.mag_nT, steps, gaps)
    if problem.still:
        return raw
    by_strength = problem.mode == "strength"
    return raw & spikes(problem.off_strength_nT if by_strength else residual, None if by_strength else steps, gaps)


def find_burst_peaks(problem: LinearProblem, left_nT: Array) -> Mask:
    """Mask (n, 3) of the highest value of every burst in the base's residual (n, 3), or in the strength.

    A burst lasts 2 to `most_burst` samples, each `never_sigma` from the local median, while both samples beside the
    burst and the median of the deviations are near: a fast turn, a passed body, or a base that does not fit, is no
    burst. A deviation of the strength, which no turn causes, may last one sample unless between two pauses. Without
    attitude the affected axis is the farthest from the line between the ends of the burst.
    """
    found, policy, by_strength = np.zeros(left_nT.shape, bool), problem.policy, problem.mode == "strength"
    seen_nT = problem.off_strength_nT if by_strength else left_nT
    seen = seen_nT / problem.sigma_nT[: seen_nT.shape[1]]
    if problem.still or not _is_quiet(np.abs(seen), policy):
        return found
    single = np.ones(len(found), bool) if by_strength else _off_strength(problem, left_nT)
    gaps = pauses_after(problem.state.time_s, policy)
    single[np.intersect1d(gaps, gaps + 1)] = False
    least = np.where(single, 1, 2)
    stands_out, off = _far(seen, policy)
    for column, far in enumerate(stands_out.T):
        for first, end in runs(far):
            at = first + int(np.argmax(off[first:end, column]))
            sharp = _ends_sharply(off[:, column], first, end, policy)
            if sharp and least[at] <= end - first <= policy.most_burst:
                found[at, _farthest(problem.recording.mag_nT, first, end, at) if by_strength else column] = True
    return found


def _ends_sharply(off: Array, first: int, end: int, policy: Policy) -> bool:
    """Whether the samples beside a run of distances (n,) are near; those beside a crest are not."""
    beside = [*off[first - 1 : first], *off[end : end + 1]]
    return max(beside, default=0.0) < max(policy.far_larger, policy.quarter * off[first:end].max())


def _off_strength(problem: LinearProblem, left_nT: Array) -> Mask:
    """Mask (n,) of outliers of the strength in the base's residual (n, 3); empty without a compared attitude."""
    if not problem.compares_across:
        return np.zeros(len(left_nT), bool)
    return _far(along_field(problem, left_nT / problem.sigma_nT)[0][:, None], problem.policy)[0][:, 0]


def _far(seen: Array, policy: Policy) -> tuple[Mask, Array]:
    """Outliers (n, q) among quiet neighbours, and the distance of each value from the local median."""
    size = (policy.burst_median, 1)
    off = np.abs(seen - median_filter(seen, size=size, mode="nearest"))
    quiet = median_filter(off, size=size, mode="nearest") < policy.somewhat_larger
    return (off > policy.never_sigma) & quiet, off


def _farthest(mag_nT: Array, first: int, end: int, at: int) -> int:
    """Axis of values (n, 3) that is farthest, at sample `at`, from the line across samples `first` to `end`."""
    ends = np.clip([first - 1, end], 0, len(mag_nT) - 1)
    share = (at - ends[0]) / max(ends[1] - ends[0], 1)
    line = mag_nT[ends[0]] + share * (mag_nT[ends[1]] - mag_nT[ends[0]])
    return int(np.argmax(np.abs(mag_nT[at] - line)))


def _across_the_field(problem: LinearProblem, residual: Array, samples: Mask) -> bool:
    """Whether the samples (n,) of a residual (n, 3) deviate across the field only, as errors of attitude or clock do.

    With rms deviation d from the neighbours, a along the field, and s along the field in the remaining samples:
    ``a^2 - s^2 < (share d)^2``.
    """
    if problem.mode != "vector" or problem.still or problem.relative:
        return False
    field_nT = residual @ np.linalg.inv(problem.turn).T
    off = field_nT - median_filter(field_nT, (problem.policy.burst_median, 1))
    along = np.einsum("ni,ni->n", problem.direction, off)
    most = problem.policy.little * np.sqrt(3) * rms(off[samples])
    return bool(rms(along[samples]) ** 2 - rms(along[~samples]) ** 2 < most**2)


def _spike_law(size_nT: Array, duration_s: float, one_size: float) -> tuple[float, float]:
    """Rate in Hz and mean size in nT of spikes (m,) with exponential sizes, the small ones hidden in noise.

    Sizes above the smallest detected have the same mean, and the true number is ``exp(least / mean)`` times the number
    detected. Spikes of nearly equal size are counted as detected.
    """
    least = float(size_nT.min())
    mean = float(size_nT.mean()) - least
    if mean < one_size * size_nT.mean():
        return len(size_nT) / duration_s, float(size_nT.mean())
    return len(size_nT) / duration_s * float(np.exp(least / mean)), mean


def runs(samples: Mask) -> NDArray[np.intp]:
    """First sample and end (m, 2) of each run of true samples (n,)."""
    return np.flatnonzero(np.diff(np.concatenate([[0], samples.astype(np.int8), [0]]))).reshape(-1, 2)


def _is_quiet(seen: Array, policy: Policy) -> bool:
    """Whether the sizes (n, q) of the base's residual, in units of the noise, are small in the median."""
    return bool((np.median(seen, axis=0) < policy.somewhat_larger).all())


def _with_neighbours(problem: LinearProblem, samples: Mask) -> Mask:
    """Mask (n,) of samples and of their neighbours within `spike_margin`."""
    width = 2 * problem.policy.spike_margin + 1
    return np.asarray(np.convolve(samples, np.ones(width), mode="same") > 0, dtype=np.bool_)


def _stated(problem: LinearProblem, sign: Sign) -> list[Any]:
    """First values of the model's own effects with a sign: sizes in nT, rates."""
    return [effect.first_value for effect in problem.effects if effect.traits.sign == sign]


def _finding(sign: Sign, samples: ArrayLike, *values: Any, stated: bool = False) -> DirectFinding | None:
    """The finding of the effect with a sign at given parameters, or None where outside the effect's bounds."""
    try:
        return DirectFinding(of_sign(sign, *values), np.asarray(samples, dtype=np.bool_), stated)
    except InputError:
        return None
