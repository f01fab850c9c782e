"""Repeated samples, pile-up at full scale and spikes, found from the values alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from calib.numerics.noise import white_noise_std
from calib.numerics.scans import RunCounts, run_counts
from scenarios.arrays import Array
from validation.policy import POLICY
from validation.signals.lattice import Lattice, find_lattice

Mask = NDArray[np.bool_]
NOISE_WINDOW = 256
"""Samples over which a local noise is estimated."""
NOISE_BLOCK = 64
"""Samples of a block whose noise is compared with the step."""
STENCIL = 8
"""Samples below which no interpolation error has two neighbours."""
LONGEST_SLOPE = 50
"""Samples at most over which the slope beside a full scale is taken."""
Side = Literal["low", "high"]
SIDES: tuple[tuple[int, Side], ...] = ((-1, "low"), (1, "high"))


@dataclass(frozen=True)
class Repeats:
    """Rows that repeat the previous row.

    repeated : number of repeating rows. hold : rows in the median run, 1 where every row is new.
    frozen : (first row, rows) of each run that is too long for chance.
    """

    repeated: int
    hold: int
    frozen: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class PileUp:
    """Full scale: `count` samples at the extreme value `level` of an axis, beyond which the motion went on."""

    axis: int
    side: Side
    level: float
    count: int


def repeats(values: Array) -> Repeats:
    """Return repeated rows of values (n, k); a row repeats where all k values do.

    A run is frozen if longer than chance explains. Where single values repeat by chance, a frozen run must also end in
    a jump of three usual steps, or be longer than the noise beside the run allows.
    """
    if len(values) < 2:
        return Repeats(0, 1, ())
    counts = run_counts(values)
    if _by_chance(counts):
        return Repeats(len(values) - counts.runs, 1, ())
    first, length = runs(values)
    hold = int(np.median(length))
    longer = length > hold
    excess = length - hold
    frozen = longer & _no_chance(excess, float(np.mean(longer)), len(length))
    if frozen.any() and _ties(values[first]) > POLICY.tie_free:
        frozen &= _jumps_after(values, first, length) | (
            length >= _longest_by_noise(values, first[frozen], length[frozen])
        )
    found = tuple((int(f), int(c)) for f, c in zip(first[frozen], length[frozen], strict=True))
    return Repeats(len(values) - len(first), hold, found)


def _by_chance(counts: RunCounts) -> bool:
    """Return whether most runs are of a single row, and chance explains the longest."""
    single = 2 * counts.single > counts.runs
    return single and not _no_chance(np.array(counts.longest - 1), 1.0 - counts.single / counts.runs, counts.runs)


def _no_chance(excess: NDArray[np.int64], share: float, runs: int) -> Mask:
    """Return where a run is longer than the median by more rows than chance allows, by the share of longer runs."""
    chance = np.clip(share, 1 / runs, 0.999)
    return np.asarray(np.log(runs) + excess * np.log(chance) < np.log(POLICY.frozen_alarm))


def runs(values: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return first index and length of every run of equal rows in values (n, k)."""
    new = np.r_[True, np.logical_or.reduce((values[1:] != values[:-1]).T)]
    first = np.flatnonzero(new)
    return first, np.diff(np.r_[first, len(values)])


def _ties(values: Array) -> float:
    """Return the share of values that occur more than once, least of all axes."""
    return min(1.0 - len(np.unique(column)) / len(column) for column in values.T)


def _jumps_after(values: Array, first: NDArray[np.intp], length: NDArray[np.intp]) -> Mask:
    """Return whether each run ends in a jump of three usual steps: the field went on during the run."""
    step = np.abs(np.diff(values[first], axis=0))
    usual = np.array([np.median(s[s > 0]) if np.any(s > 0) else np.inf for s in step.T])
    jump = np.r_[np.any(step > POLICY.frozen_jump * usual, axis=1), False]
    return np.asarray(jump & (length >= POLICY.least_frozen))


def _longest_by_noise(values: Array, first: NDArray[np.intp], length: NDArray[np.intp]) -> float:
    """Return the rows of the longest run of equal rows that noise allows, from the values outside the runs given.

    P(two values round alike) = step / (2 sqrt(pi) sigma),  sigma the noise of the quietest block

    Infinite where the noise is not known; a noise below the step allows nearly any length.
    """
    outside = np.ones(len(values), np.bool_)
    for one, rows in zip(first, length, strict=True):
        outside[one + 1 : one + rows] = False
    alone = values[outside]
    if len(alone) < NOISE_BLOCK:
        return float("inf")
    blocks = np.array_split(alone, len(alone) // NOISE_BLOCK)
    noise = np.min([white_noise_std(block) for block in blocks], axis=0)
    step = np.array([_coarseness(column) for column in alone.T])
    seen = noise > POLICY.noisy_step * step
    alike = np.where(seen, step, 1.0) / np.where(seen, 2 * np.sqrt(np.pi) * noise, 1.0)
    chance = float(np.clip(np.prod(alike), 1 / len(values), POLICY.most_alike))
    return float(max(POLICY.least_frozen, 1 + np.log(POLICY.frozen_alarm / len(values)) / np.log(chance)))


def _coarseness(column: Array) -> float:
    """Return the step of values (n,): of their lattice, 0 where values hardly repeat, else infinite: not known."""
    lattice = find_lattice(column)
    if lattice is not None:
        return lattice.step
    return np.inf if _ties(column[:, None]) > POLICY.tie_free else 0.0


def pile_up(values: Array, lattices: tuple[Lattice | None, ...]) -> list[PileUp]:
    """Return full scales of values (n, k), by axis and side; lattices as from `find_lattice`.

    Values without ties: three equal extremes suffice. Noise above the step: the outermost code must hold four times
    the samples of the next code. Less noise: on at least two visits the course before and after a run must extend four
    steps beyond the level while other axes move on.
    """
    values = values[np.isfinite(values).all(axis=1)]
    if len(values) < 2:
        return []
    fresh = values[runs(values)[0]]
    noise = white_noise_std(fresh)
    found = []
    for axis, lattice in enumerate(lattices):
        column = fresh[:, axis]
        if np.ptp(column) == 0:
            continue
        for sign, side in SIDES:
            at = sign * column == (sign * column).max()
            if at.sum() < POLICY.least_at_level:
                continue
            ties = _ties(column[~at][:, None]) > POLICY.tie_free
            step = lattice.step if lattice and not lattice.floating else 0.0
            if _is_pile(sign * fresh, axis, at, step, float(noise[axis]), ties):
                level = float(column[at][0])
                found.append(PileUp(axis, side, level, int(np.count_nonzero(values[:, axis] == level))))
    return found


def _is_pile(values: Array, axis: int, at: Mask, step: float, noise: float, ties: bool) -> bool:
    """Return whether too many samples `at` the greatest value of an axis show a full scale."""
    if not ties:
        return True
    if noise >= step > 0:
        inner = values[~at, axis]
        edge = inner.max() - 0.5 * step
        beside = np.count_nonzero(inner >= edge)
        return bool(at.sum() >= POLICY.least_pile and at.sum() > POLICY.pile_ratio * beside)
    edges = np.flatnonzero(np.diff(np.r_[False, at, False]))
    visits = (_overshoots(values, axis, a, b, max(step, noise)) for a, b in edges.reshape(-1, 2))
    return sum(visits) >= POLICY.least_visits


def _overshoots(values: Array, axis: int, start: int, stop: int, unit: float) -> bool:
    """Return whether a parabola with the slopes before and after rows start to stop exceeds their level.

    A parabola of end slopes s_1, -s_2 over n steps rises (s_1 + s_2) n / 8. The other axes must move on meanwhile.
    """
    length = stop - start
    span = min(max(length // 2, 2), LONGEST_SLOPE)
    if start < span + 1 or stop + span + 1 > len(values) or length < 2:
        return False
    column = values[:, axis]
    before = (column[start - 1] - column[start - 1 - span]) / span
    after = (column[stop] - column[stop + span]) / span
    others = np.delete(values[start:stop], axis, axis=1)
    moved = float(np.ptp(others, axis=0).max()) if others.size else np.inf
    slope = min(before, after)
    rise = (before + after) * (length + 1) / 8
    return bool(rise > POLICY.overshoot * unit and moved > POLICY.moved_on * slope * length)


def spikes(values: Array, steps: Array | None = None, gaps: NDArray[np.intp] | None = None) -> Mask:
    """Return a mask (n, k) of single wrong values (n, k): far from the cubic through two neighbours on either side.

    e_i = v_i - (4 (v_{i-1} + v_{i+1}) - v_{i-2} - v_{i+2}) / 6

    A spike has e of 8 local standard deviations, neighbours with e of opposite sign and two thirds of the size, and
    equal slopes beside and across the spike; jumps and rough stretches have not.
    steps : (k,) least significant bits, a lower limit of the noise.
    gaps : samples before a gap; two samples on either side of a gap are not judged.
    """
    found = np.zeros(values.shape, np.bool_)
    if len(values) < STENCIL:
        return found
    floor = np.zeros(values.shape[1]) if steps is None else POLICY.spike_step * steps
    for axis, column in enumerate(values.T):
        found[_single(column, float(floor[axis])), axis] = True
    if gaps is not None and len(gaps):
        found[np.clip(gaps[:, None] + np.arange(-1, 3), 0, len(values) - 1).ravel()] = False
    return found


def _single(column: Array, floor: float) -> NDArray[np.intp]:
    """Return indices of the spikes of one axis (n,)."""
    e = column[2:-2] - (4 * (column[1:-3] + column[3:-1]) - column[:-4] - column[4:]) / 6
    size = np.abs(e)
    std = np.maximum(_local_std(size), floor)
    large = np.flatnonzero(size[1:-1] > POLICY.spike_sigma * std[1:-1]) + 1
    height, at = size[large], large + 2
    highest = height > POLICY.spike_peak * np.maximum(size[large - 1], size[large + 1])
    sign = np.sign(e[large])
    opposite = np.maximum(sign * e[large - 1], sign * e[large + 1]) < -POLICY.spike_opposite * height
    slopes = column[at + 1] - column[at - 1], column[at - 1] - column[at - 2] + column[at + 2] - column[at + 1]
    tolerance = np.maximum(POLICY.spike_slope * height, POLICY.spike_slope_sigma * std[large])
    agreed = np.abs(slopes[0] - slopes[1]) / 2 < tolerance
    return np.asarray(at[highest & opposite & agreed], np.intp)


def _local_std(size: Array) -> Array:
    """Return robust standard deviations (n,) of an error of size (n,): overall, or local where larger."""
    overall = np.median(size) / 0.6745
    blocks = max(len(size) // NOISE_WINDOW, 1)
    length, longer = divmod(len(size), blocks)
    cut = longer * (length + 1)  # the first parts are longer by one, as numpy splits an array
    parts = size[:cut].reshape(longer, length + 1), size[cut:].reshape(blocks - longer, length)
    local = np.concatenate([np.median(part, axis=1) for part in parts if part.size]) / 0.6745
    widest = np.maximum(local, np.maximum(np.r_[local[1:], 0], np.r_[0, local[:-1]]))
    return np.asarray(np.maximum(np.repeat(widest, [length + 1] * longer + [length] * (blocks - longer)), overall))
