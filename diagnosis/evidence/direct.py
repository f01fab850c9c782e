"""Direct evidence, without a fit: rounding, full scale, repeated and wrong values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import binary_dilation, median_filter

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
    if clipped is None:  # a clipped stretch has no noise of its own to measure a spike by
        found.append(_wrong_values(problem, lattices))
    return [finding for finding in found if finding is not None and finding.effect.name not in without]


def held_rows(problem: LinearProblem) -> Mask:
    """Mask (n,) of rows that repeat the row before because no new value was measured."""
    return held(problem.recording.mag_nT, problem.off_nT, problem.policy)


def find_start_samples(problem: LinearProblem) -> Mask:
    """Mask (n,) of samples so soon after a start that a lagging measurement may show the field before the start.

    Two samples of this kind, in a recording that begins in motion, would outweigh the remaining samples in the test of
    an effect's form. With attitude only, and at most a small share of the samples.
    """
    policy, time_s, sections = problem.policy, problem.recording.time_s, problem.sections
    after_start = np.zeros(len(time_s), dtype=bool)
    most_s = min(policy.start_s, policy.start_share * len(time_s) * problem.state.interval_s / len(sections))
    for section in sections if problem.along_attitude else ():
        after_start[section] = time_s[section] - time_s[section.start] < most_s
    return after_start


def _rounded(problem: LinearProblem, lattices: Lattices) -> DirectFinding | None:
    """Values on a lattice with a step other than the model's."""
    steps = [lattice.step for lattice in lattices if lattice is not None and not lattice.floating]
    if len(steps) < len(lattices):
        return None
    policy, step = problem.policy, float(np.median(steps))
    stated = abs(step - _stated(problem, "lattice")) < policy.same_step * step
    if stated or step < policy.trace * problem.sigma_nT.min():
        return None
    return _finding("lattice", np.zeros(len(problem.recording)), step)


def _clipped(problem: LinearProblem, lattices: Lattices) -> DirectFinding | None:
    """Values that pile up at a full scale."""
    mag_nT = problem.recording.mag_nT
    if not (piles := pile_up(mag_nT, lattices)):
        return None
    level = float(np.median([abs(pile.level) for pile in piles]))
    stated = abs(level - _stated(problem, "full_scale")) < problem.policy.same_full_scale * level
    return _finding("full_scale", (np.abs(mag_nT) >= level * (1 - 1e-9)).any(axis=1), level, stated=stated)


def _held(problem: LinearProblem) -> DirectFinding | None:
    """Repeated rows, of all the held ones where these come at random: a slower sensor's come evenly."""
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
    """Number and mean length of gaps in sample intervals, from the repeated rows (m,) of each gap that is seen.

    ``P(k rows) ~ exp(-k / d)``, and ``1 - d (1 - exp(-1 / d))`` of no row; gaps of one length are counted as they are.
    """
    mean = float(lengths.mean())
    if np.ptp(lengths) == 0:
        return len(lengths), mean
    d = -1.0 / np.log(1.0 - 1.0 / mean)
    return float(len(lengths) / (d * -np.expm1(-1.0 / d))), float(d)


def _wrong_values(problem: LinearProblem, lattices: Lattices) -> DirectFinding | None:
    """Isolated outliers and bursts, unless beside a repeated row, an invalid one, or a current's spike."""
    policy, mag_nT = problem.policy, problem.recording.mag_nT
    invalid = repeated(mag_nT) | (problem.usable == 0) | spikes(problem.state.current_A).any(axis=1)
    valid = ~binary_dilation(invalid, iterations=policy.spike_margin)
    where: Mask = (_isolated(problem, lattices) | find_burst_peaks(problem)) & valid[:, None]
    samples: Mask = np.asarray(where.any(axis=1))
    if np.count_nonzero(where) < policy.least_spikes or _across_the_field(problem, samples):
        return None
    far, peaks = _far_runs(problem, valid)
    if problem.mode == "vector" and np.count_nonzero(peaks) >= policy.least_spikes:
        where = peaks  # the smaller ones too: their law is known by more of them
    residual = mag_nT - problem.clean_nT
    sizes_nT = np.abs(residual - np.median(residual, axis=0))[where]
    rate_hz, mean_nT = _spike_law(sizes_nT, len(residual) * problem.state.interval_s, policy.quarter)
    return _finding("outliers", samples | far, rate_hz, mean_nT, stated=bool(_stated(problem, "outliers")))


def _far_runs(problem: LinearProblem, valid: Mask) -> tuple[Mask, Mask]:
    """Valid samples (n,) in short runs far from the base, and high peaks (n, q) of the runs; a passed body lasts."""
    policy, size = problem.policy, np.abs(_quiet_deviation(problem))
    far, peaks = np.zeros(len(size), np.bool_), np.zeros(size.shape, np.bool_)
    for first, end in runs(np.asarray((size > policy.far_sigma).any(axis=1))):
        if end - first <= policy.most_burst:
            far[first:end] = valid[first:end]
            within = size[first:end] * valid[first:end, None]
            sample, axis = np.unravel_index(np.argmax(within), within.shape)
            peaks[first + sample, axis] = within[sample, axis] > policy.never_sigma
    return far, peaks


def _isolated(problem: LinearProblem, lattices: Lattices) -> Mask:
    """Isolated outliers (n, 3), in the raw values and beside the base: a fast turn is no spike."""
    steps = np.array([0.0 if lattice is None else lattice.step for lattice in lattices])
    gaps = pauses_after(problem.state.time_s, problem.policy)
    beside_base = spikes(problem.off_nT, None if problem.mode == "strength" else steps, gaps)
    return np.asarray(spikes(problem.recording.mag_nT, steps, gaps) & beside_base)


def find_burst_peaks(problem: LinearProblem) -> Mask:
    """Mask (n, 3) of the highest value of every burst beside the base.

    A burst lasts 2 to `most_burst` samples, each `never_sigma` from the local median, while both samples beside the
    burst and the median of the deviations are near: a fast turn or a passed body is no burst. A deviation of the
    strength, which no turn causes, may last one sample unless between two pauses. Without attitude the affected axis is
    the farthest from the line between the ends of the burst.
    """
    policy, mag_nT, seen = problem.policy, problem.recording.mag_nT, _quiet_deviation(problem)
    found, may_be_single = np.zeros(mag_nT.shape, bool), np.full(len(mag_nT), problem.mode == "strength")
    if problem.still:
        return found
    if problem.along_attitude:
        may_be_single = _far(along_field(problem, seen)[0][:, None], policy)[0][:, 0]
    gaps = pauses_after(problem.state.time_s, policy)
    may_be_single[np.intersect1d(gaps, gaps + 1)] = False
    stands_out, off = _far(seen, policy)
    for column, far in enumerate(stands_out.T):
        for first, end in runs(far):
            at = first + int(np.argmax(off[first:end, column]))
            sharp = _ends_sharply(off[:, column], first, end, policy)
            if sharp and 2 - may_be_single[at] <= end - first <= policy.most_burst:
                found[at, column if problem.mode == "vector" else _farthest(mag_nT, first, end, at)] = True
    return found


def _ends_sharply(off: Array, first: int, end: int, policy: Policy) -> bool:
    """Whether the samples beside a run of distances (n,) are near; those beside a crest are not."""
    beside = [*off[first - 1 : first], *off[end : end + 1]]
    return bool(max(beside, default=0.0) < max(policy.far_larger, policy.quarter * off[first:end].max()))


def _quiet_deviation(problem: LinearProblem) -> Array:
    """Deviation (n, q) from the base in units of the noise; 0 where large in the median: such a base does not fit."""
    seen = problem.off_nT / problem.sigma_nT[: problem.off_nT.shape[1]]
    return np.asarray(seen * bool((np.median(np.abs(seen), axis=0) < problem.policy.somewhat_larger).all()))


def _far(seen: Array, policy: Policy) -> tuple[Mask, Array]:
    """Outliers (n, q) among quiet neighbours, and the distance of each value from the local median."""
    size = (policy.burst_median, 1)
    off = np.abs(seen - median_filter(seen, size=size, mode="nearest"))
    far = off > policy.never_sigma
    if far.any():
        far &= median_filter(off, size=size, mode="nearest") < policy.somewhat_larger
    return far, off


def _farthest(mag_nT: Array, first: int, end: int, at: int) -> int:
    """Axis of values (n, 3) that is farthest, at sample `at`, from the line between the samples beside a run."""
    ends = np.clip([first - 1, end], 0, len(mag_nT) - 1)
    line_nT = [np.interp(at, ends, axis[ends]) for axis in mag_nT.T]
    return int(np.argmax(np.abs(mag_nT[at] - line_nT)))


def _across_the_field(problem: LinearProblem, samples: Mask) -> bool:
    """Whether the samples (n,) deviate from the base across the field only, as errors of attitude or clock do.

    With rms deviation d from the neighbours, a along the field, and s along the field in the remaining samples:
    ``a^2 - s^2 < (share d)^2``.
    """
    if not problem.along_attitude:
        return False
    field_nT = problem.ahead_of_iron(problem.off_nT)
    off = field_nT - median_filter(field_nT, (problem.policy.burst_median, 1))
    along = np.einsum("ni,ni->n", problem.direction, off)
    most = problem.policy.little * np.sqrt(3) * rms(off[samples])
    return bool(rms(along[samples]) ** 2 - rms(along[~samples]) ** 2 < most**2)


def _spike_law(size_nT: Array, duration_s: float, one_size: float) -> tuple[float, float]:
    """Rate in Hz and mean size in nT of spikes (m,) with exponential sizes, the small ones hidden in noise.

    Sizes above the least seen have the same mean, and ``exp(least / mean)`` times as many are there; but not where
    nearly all have one size.
    """
    least, whole, rate_hz = float(size_nT.min()), float(size_nT.mean()), len(size_nT) / duration_s
    mean = whole - least
    return (rate_hz, whole) if mean < one_size * whole else (rate_hz * float(np.exp(least / mean)), mean)


def runs(samples: Mask) -> NDArray[np.intp]:
    """First sample and end (m, 2) of each run of true samples (n,)."""
    return np.flatnonzero(np.diff(samples, prepend=False, append=False)).reshape(-1, 2)


def _stated(problem: LinearProblem, sign: Sign) -> float:
    """First value, a size in nT or a rate, of the model's own effect with a sign; 0 without such an effect."""
    return next((effect.first_value for effect in reversed(problem.effects) if effect.traits.sign == sign), 0.0)


def _finding(sign: Sign, samples: ArrayLike, *values: Any, stated: bool = False) -> DirectFinding | None:
    """The finding of the effect with a sign at given parameters, or None where outside the effect's bounds."""
    try:
        return DirectFinding(of_sign(sign, *values), np.asarray(samples, dtype=np.bool_), stated)
    except InputError:
        return None
