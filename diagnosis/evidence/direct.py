"""Direct evidence, without a fit: rounding, full scale, repeated and wrong values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import median_filter

from diagnosis.evidence.bursts import find_burst_peaks, runs
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem, held, pauses_after, repeated
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


def _rounded(problem: LinearProblem, lattices: Lattices) -> DirectFinding | None:
    """Values on a lattice with a step other than the model's."""
    steps = [lattice.step for lattice in lattices if lattice is not None and not lattice.floating]
    if len(steps) < len(lattices):
        return None
    policy, step = problem.policy, float(np.median(steps))
    given = _stated_nT(problem, "lattice")
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
    given = _stated_nT(problem, "full_scale")
    stated = abs(level - given) < problem.policy.same_full_scale * level
    return _finding("full_scale", np.any(np.abs(mag) >= level * (1 - 1e-9), axis=1), level, stated=stated)


def _held(problem: LinearProblem) -> DirectFinding | None:
    """Repeated rows, unless the model has dropouts: all of them, or the long ones where rounding repeats rows too."""
    found, samples = repeats(problem.recording.mag_nT), repeated(problem.recording.mag_nT)
    lengths = _gap_lengths(held_rows(problem), problem.policy)
    if not len(lengths):
        lengths = np.array([rows - 1 for _, rows in found.frozen])
    if not len(lengths) or found.hold > 1 or _is_stated(problem, "repeats"):
        return None
    work_s, (number, length) = np.count_nonzero(~samples) * problem.state.interval_s, _dropout_law(lengths)
    return _finding("repeats", samples, number / work_s, length * problem.state.interval_s)


def _gap_lengths(held: Mask, policy: Policy) -> Array:
    """Lengths (m,) of the runs of held rows (n,), where they come at random: a slower sensor's come evenly."""
    gaps = runs(held)
    intervals = np.diff(gaps[:, 0])
    if len(gaps) < policy.least_spikes or intervals.std() < policy.half * intervals.mean():
        return np.zeros(0)
    return np.asarray(np.diff(gaps, axis=1)[:, 0])


def _dropout_law(lengths: Array) -> tuple[float, float]:
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
    """Isolated outliers, unless a neighbour is repeated, clipped or a current's spike."""
    policy, residual = problem.policy, problem.recording.mag_nT - problem.clean_nT
    where = _single_outliers(problem, lattices, residual, beside)
    single: Mask = np.asarray(where.any(axis=1))
    if np.count_nonzero(where) < policy.least_spikes or _across_the_field(problem, residual, single):
        return None
    seen, sizes_nT = _seen(problem, residual), np.abs(residual - np.median(residual, axis=0))
    far = _short_runs(np.asarray((seen > policy.far_sigma).any(axis=1)), policy.most_burst) & ~beside
    quiet = _quiet(seen, policy)
    if problem.mode == "vector" and quiet:  # the smaller ones too: their law is known by more of them
        peaks = _peaks(far, seen) & (seen > policy.never_sigma)
        where = peaks if np.count_nonzero(peaks) >= policy.least_spikes else where
    rate_hz, mean_nT = _spike_law(sizes_nT[where], len(residual) * problem.state.interval_s, policy.quarter)
    return _finding("outliers", single | (far & quiet), rate_hz, mean_nT, stated=_is_stated(problem, "outliers"))


def _single_outliers(problem: LinearProblem, lattices: Lattices, residual: Array, beside: Mask) -> Mask:
    """Mask (n, 3) of isolated outliers of a residual (n, 3), none beside given samples or a current's own spike."""
    steps = np.array([0.0 if lattice is None else lattice.step for lattice in lattices])
    currents = np.asarray(spikes(problem.state.current_A).any(axis=1), dtype=np.bool_)
    found = _standing_out(problem, residual, steps) | find_burst_peaks(problem, residual)
    return np.asarray(found & ~(beside | _with_neighbours(problem, currents))[:, None], dtype=np.bool_)


def _peaks(far: Mask, seen: Array) -> Mask:
    """Mask (n, q) of the largest value of sizes (n, q) in each run of far samples (n,)."""
    peaks = np.zeros(seen.shape, np.bool_)
    for first, end in runs(far):
        sample, axis = np.unravel_index(np.argmax(seen[first:end]), seen[first:end].shape)
        peaks[first + sample, axis] = True
    return peaks


def _seen(problem: LinearProblem, residual: Array) -> Array:
    """Size (n, q) of the base's residual (n, 3), or of the strength's error, in units of the noise."""
    return np.abs(problem.target[:, :1] if problem.mode == "strength" else residual / problem.sigma_nT)


def _across_the_field(problem: LinearProblem, residual: Array, samples: Mask) -> bool:
    """Whether the samples (n,) deviate across the field only, as errors of attitude or clock do.

    left (n, 3): residual of the base. With rms deviation d from the neighbours, a along the field, and s along the
    field in the remaining samples: ``a^2 - s^2 < (share d)^2``.
    """
    if problem.mode != "vector" or problem.still or problem.relative:
        return False
    field_nT = residual @ np.linalg.inv(problem.turn).T
    off = field_nT - median_filter(field_nT, (problem.policy.burst_median, 1))
    along = np.einsum("ni,ni->n", problem.direction, off)
    most = problem.policy.little * np.sqrt(3) * rms(off[samples])
    return bool(rms(along[samples]) ** 2 - rms(along[~samples]) ** 2 < most**2)


def _standing_out(problem: LinearProblem, residual: Array, steps: Array) -> Mask:
    """Isolated outliers (n, 3), in the raw values and in the base's residual: a fast turn is no spike.

    Where only the strength is known the strength must deviate; deviations across the field do not count.
    """
    gaps = pauses_after(problem.state.time_s, problem.policy)
    raw = spikes(problem.recording.mag_nT, steps, gaps)
    if problem.still:
        return raw
    along = problem.off_strength_nT if problem.mode == "strength" else residual
    return raw & spikes(along, steps if problem.mode == "vector" else None, gaps)


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


def _quiet(seen: Array, policy: Policy) -> bool:
    """Whether the base's residual (n, q), in units of the noise, is so small that a far sample must be wrong."""
    return bool((np.median(seen, axis=0) < policy.somewhat_larger).all())


def _short_runs(far: Mask, most: int) -> Mask:
    """The samples (n,) of runs of at most `most`: a body beside the path, or a base that does not fit, lasts longer."""
    short = np.zeros(len(far), np.bool_)
    for first, end in runs(far):
        if end - first <= most:
            short[first:end] = True
    return short


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


def _with_neighbours(problem: LinearProblem, samples: Mask) -> Mask:
    """Mask (n,) of samples and of their neighbours within `spike_margin`."""
    width = 2 * problem.policy.spike_margin + 1
    return np.asarray(np.convolve(samples, np.ones(width), mode="same") > 0, dtype=np.bool_)


def _is_stated(problem: LinearProblem, sign: Sign) -> bool:
    return any(effect.traits.sign == sign for effect in problem.effects)


def _stated_nT(problem: LinearProblem, sign: Sign) -> float:
    """Size in nT of the model's own effect with a sign, 0 without such an effect."""
    sizes_nT = [effect.first_value for effect in problem.effects if effect.traits.sign == sign]
    return float([0.0, *sizes_nT][-1])


def _finding(sign: Sign, samples: ArrayLike, *values: Any, stated: bool = False) -> DirectFinding | None:
    """The finding of the effect with a sign at given parameters, or None where outside the effect's bounds."""
    try:
        return DirectFinding(of_sign(sign, *values), np.asarray(samples, dtype=np.bool_), stated)
    except InputError:
        return None
