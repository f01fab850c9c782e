"""Direct evidence, before any fit: what the values themselves show of the converter and the electronics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from diagnosis.evidence.bursts import highest_of_bursts
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem, pauses_after
from diagnosis.problem.repeated_rows import held, repeated
from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.effects.base import Effect
from sim.effects.electronics import Quantisation, Saturation
from sim.effects.faults import Dropouts, Spikes
from validation.signals.amplitude import rms
from validation.signals.faults import pile_up, repeats, spikes
from validation.signals.lattice import Lattice, find_lattice

Mask = NDArray[np.bool_]
Lattices = tuple[Lattice | None, ...]


@dataclass(frozen=True)
class Direct:
    """An effect seen in the values themselves, and the samples (n,) that are no measurements because of it."""

    effect: Effect
    samples: Mask


def direct_evidence(problem: LinearProblem, without: frozenset[str] = frozenset()) -> list[Direct]:
    """Rounding, full scale, repeated and single wrong values; effects in `without` are left out."""
    lattices = tuple(find_lattice(axis) for axis in problem.recording.mag_nT.T)
    clipped = _clipped(problem, lattices)
    found = [_rounded(problem, lattices), clipped, _held(problem)]
    no_values = [repeated(problem.recording.mag_nT), problem.usable == 0]
    gone = np.logical_or.reduce([*no_values, *(one.samples for one in found if one is not None)])
    if clipped is None:  # a clipped stretch has no noise of its own to measure a spike by
        found.append(_wrong_values(problem, lattices, _beside(problem, gone)))
    return [one for one in found if one is not None and one.effect.name not in without]


def _rounded(problem: LinearProblem, lattices: Lattices) -> Direct | None:
    """Values that lie on a lattice of another step than the model's."""
    steps = [one.step for one in lattices if one is not None and not one.floating]
    if len(steps) < len(lattices):
        return None
    policy, step = problem.policy, float(np.median(steps))
    given = [0.0, *(one.step_nT for one in problem.effects if isinstance(one, Quantisation))][-1]
    if step < policy.least_step_sigma * problem.sigma_nT.min() or abs(step - given) < policy.same_step * step:
        return None
    return _possible(Quantisation, np.zeros(len(problem.recording)), step_nT=step)


def _clipped(problem: LinearProblem, lattices: Lattices) -> Direct | None:
    """Values that pile up at another full scale than the model's."""
    mag = problem.recording.mag_nT
    piles = pile_up(mag, lattices)
    if not piles:
        return None
    level = float(np.median([abs(one.level) for one in piles]))
    given = [0.0, *(one.full_scale_nT for one in problem.effects if isinstance(one, Saturation))][-1]
    if abs(level - given) < problem.policy.same_full_scale * level:
        return None
    return _possible(Saturation, (np.abs(mag) >= level * (1 - 1e-9)).any(axis=1).astype(bool), full_scale_nT=level)


def _held(problem: LinearProblem) -> Direct | None:
    """Rows that repeat the row before, where the model has no dropouts."""
    found = repeats(problem.recording.mag_nT)
    if not found.frozen or found.hold > 1 or any(isinstance(one, Dropouts) for one in problem.effects):
        return None
    samples = repeated(problem.recording.mag_nT)
    work_s = np.count_nonzero(~samples) * problem.state.interval_s
    # A gap hides its first sample in the one before it; lengths are exponential, so half a sample is added.
    lengths = (np.array([rows for _, rows in found.frozen]) - 0.5) * problem.state.interval_s
    return _possible(Dropouts, samples, rate_hz=len(lengths) / work_s, mean_duration_s=float(lengths.mean()))


def _wrong_values(problem: LinearProblem, lattices: Lattices, beside: Mask) -> Direct | None:
    """Single values far off, where the model has no spikes; none beside what is held, clipped or a spiked current."""
    mag, policy = problem.recording.mag_nT, problem.policy
    steps = np.array([0.0 if one is None else one.step for one in lattices])
    currents = np.asarray(spikes(problem.state.current_A).any(axis=1), dtype=np.bool_)
    left = mag - problem.clean_nT
    where = (_standing_out(problem, left, steps) | highest_of_bursts(problem, left)) & ~(
        beside | _beside(problem, currents)
    )[:, None]
    if np.count_nonzero(where) < policy.least_spikes or any(isinstance(one, Spikes) for one in problem.effects):
        return None
    rate_hz, mean_nT = _spike_law(
        np.abs(left - np.median(left, axis=0))[where], len(left) * problem.state.interval_s, policy.one_size
    )
    single: Mask = np.asarray(where.any(axis=1))
    if _across_the_field(problem, left, single):
        return None
    seen = _seen(problem, left)
    far = (seen > policy.far_sigma).any(axis=1) & (single | _quiet(seen, policy)) & ~beside
    return _possible(Spikes, single | far, rate_hz=rate_hz, amplitude_nT=mean_nT)


def _seen(problem: LinearProblem, left: Array) -> Array:
    """Size (n, q) of what the base leaves (n, 3), or of what the strength is off by, in units of the noise."""
    return np.abs(problem.target[:, :1] if problem.mode == "strength" else left / problem.sigma_nT)


def _across_the_field(problem: LinearProblem, left: Array, samples: Mask) -> bool:
    """Whether samples (n,) are off across the field alone, which an error of the attitude or of a clock is.

    left (n, 3): what the base leaves. Off their neighbours by d, along the field by a, others along it by s:
    ``a^2 - s^2 < (share d)^2``.
    """
    if problem.mode != "vector" or problem.still or problem.relative:
        return False
    field_nT = left @ np.linalg.inv(problem.turn).T
    off = field_nT - median_filter(field_nT, (problem.policy.burst_median, 1))
    along = np.einsum("ni,ni->n", problem.direction, off)
    most = problem.policy.off_along * np.sqrt(3) * rms(off[samples])
    return bool(rms(along[samples]) ** 2 - rms(along[~samples]) ** 2 < most**2)


def _standing_out(problem: LinearProblem, left: Array, steps: Array) -> Mask:
    """Single values (n, 3) far off their neighbours, and in what the base leaves too: a fast turn is no spike.

    Where only the strength is known it must show one: what lies across the field does not matter to it.
    """
    gaps = pauses_after(problem.state.time_s, problem.policy)
    raw = spikes(problem.recording.mag_nT, steps, gaps)
    if problem.still:
        return raw
    along = problem.off_strength_nT if problem.mode == "strength" else left
    return raw & spikes(along, steps if problem.mode == "vector" else None, gaps)


def _spike_law(size_nT: Array, duration_s: float, one_size: float) -> tuple[float, float]:
    """Rate in Hz and mean size in nT of spikes (m,) of exponential size, of which small ones drown in the noise.

    What is above the least seen has the same mean, and ``exp(least / mean)`` times as many are there as are seen. Those
    of nearly one size follow no such law, and are all that there are.
    """
    least = float(size_nT.min())
    mean = float(size_nT.mean()) - least
    if mean < one_size * size_nT.mean():
        return len(size_nT) / duration_s, float(size_nT.mean())
    return len(size_nT) / duration_s * float(np.exp(least / mean)), mean


def _quiet(seen: Array, policy: Policy) -> bool:
    """Whether the base leaves so little (n, q), in units of the noise, that a far sample must be a wrong one."""
    return bool((np.median(seen, axis=0) < policy.quiet_sigma).all())


def held_rows(problem: LinearProblem) -> Mask:
    """Rows (n,) that repeat the row before because nothing new was measured."""
    mag_nT = problem.recording.mag_nT
    left = problem.off_strength_nT if problem.mode == "strength" else mag_nT - problem.clean_nT
    return held(mag_nT, left, problem.policy)


def _beside(problem: LinearProblem, samples: Mask) -> Mask:
    """Samples (n,) and those beside them."""
    width = 2 * problem.policy.spike_margin + 1
    return np.asarray(np.convolve(samples, np.ones(width), mode="same") > 0, dtype=np.bool_)


def _possible(effect: type[Effect], samples: Array | Mask, **values: Any) -> Direct | None:
    """The evidence, where the effect takes such values."""
    try:
        return Direct(effect(**values), np.asarray(samples, dtype=np.bool_))
    except InputError:
        return None
