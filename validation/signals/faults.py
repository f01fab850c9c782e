"""Repeated samples, pile-up at full scale and spikes, found in the values alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from calib.numerics.noise import white_noise_std
from scenarios.arrays import Array
from validation.signals.lattice import Lattice

Mask = NDArray[np.bool_]
TIE_FREE = 0.01
"""Values that repeat more rarely than this share of the time do not repeat by themselves."""
FROZEN_CHANCE = 1e-3
"""Expected number of runs as long by chance, below which a run counts as frozen."""
LEAST_AT_LEVEL = 3
OVERSHOOT = 4.0
"""How far a smooth motion would have gone beyond the level, in steps or noise, to count as cut off."""
LEAST_VISITS = 2
PILE_RATIO = 4.0
"""Least ratio of the outermost code's count to its neighbour's."""
SPIKE_SIGMAS = 8.0
"""Size of a spike in local standard deviations of the interpolation error."""
SLOPE_TOLERANCE = 0.25
"""Share of a spike's size by which the slopes beside it and across it may differ."""
NOISE_WINDOW = 256
LONGEST_SLOPE = 50
Side = Literal["low", "high"]
SIDES: tuple[tuple[int, Side], ...] = ((-1, "low"), (1, "high"))


@dataclass(frozen=True)
class Repeats:
    """Rows that repeat the row before: their number, the usual run, and runs too long for chance.

    hold : rows in a usual run, 1 where every row is new. frozen : (first row, rows) of each run that is too long.
    """

    repeated: int
    hold: int
    frozen: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class PileUp:
    """`count` samples stand at the least or greatest value `level` of an axis, where the motion went beyond it."""

    axis: int
    side: Side
    level: float
    count: int


def repeats(values: Array) -> Repeats:
    """Repeated rows of values (n, k); a row repeats when all its values do.

    Values without ties cannot repeat by themselves; of others a run counts as frozen when it is longer than chance
    explains and ends in a jump, three times the usual step.
    """
    if len(values) < 2:
        return Repeats(0, 1, ())
    first, length = runs(values)
    hold = int(np.median(length))
    longer = length > hold
    excess = length - hold
    chance = np.clip(np.mean(longer), 1 / len(length), 0.999)
    frozen = longer & (np.log(len(length)) + excess * np.log(chance) < np.log(FROZEN_CHANCE))
    if _ties(values[first]) > TIE_FREE:
        frozen &= _jumps_after(values, first, length)
    found = tuple((int(f), int(c)) for f, c in zip(first[frozen], length[frozen], strict=True))
    return Repeats(len(values) - len(first), hold, found)


def runs(values: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """First index and length of every run of equal rows in values (n, k)."""
    new = np.r_[True, np.any(values[1:] != values[:-1], axis=1)]
    first = np.flatnonzero(new)
    return first, np.diff(np.r_[first, len(values)])


def _ties(values: Array) -> float:
    """Least share, over the axes, of values that another row has too."""
    return min(1.0 - len(np.unique(column)) / len(column) for column in values.T)


def _jumps_after(values: Array, first: NDArray[np.intp], length: NDArray[np.intp]) -> Mask:
    """Whether each run ends in a jump: three times the usual step, by which the field went on meanwhile."""
    step = np.abs(np.diff(values[first], axis=0))
    usual = np.array([np.median(s[s > 0]) if np.any(s > 0) else np.inf for s in step.T])
    jump = np.r_[np.any(step > 3 * usual, axis=1), False]
    return np.asarray(jump & (length >= 3))


def pile_up(values: Array, lattices: tuple[Lattice | None, ...]) -> list[PileUp]:
    """Axes of values (n, k) that stand at their least or greatest value; lattices as `find_lattice` gives them.

    Without ties three equal extremes suffice. With noise above the step the outermost code must hold PILE_RATIO times
    its neighbour. With less noise the motion before and after a run must lead OVERSHOOT steps beyond it, the other
    axes moving on meanwhile, on two visits at least.
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
        ties = _ties(column[:, None]) > TIE_FREE
        for sign, side in SIDES:
            at = sign * column == (sign * column).max()
            step = lattice.step if lattice and not lattice.floating else 0.0
            if at.sum() >= LEAST_AT_LEVEL and _is_pile(sign * fresh, axis, at, step, float(noise[axis]), ties):
                level = float(column[at][0])
                found.append(PileUp(axis, side, level, int(np.count_nonzero(values[:, axis] == level))))
    return found


def _is_pile(values: Array, axis: int, at: Mask, step: float, noise: float, ties: bool) -> bool:
    """Whether the samples `at` the greatest value of an axis are too many."""
    if not ties:
        return True
    if noise >= step > 0:
        inner = values[~at, axis]
        beside = np.count_nonzero(inner >= inner.max() - 0.5 * step)
        return bool(at.sum() >= 10 and at.sum() > PILE_RATIO * beside)
    edges = np.flatnonzero(np.diff(np.r_[False, at, False]))
    visits = (_overshoots(values, axis, a, b, max(step, noise)) for a, b in edges.reshape(-1, 2))
    return sum(visits) >= LEAST_VISITS


def _overshoots(values: Array, axis: int, start: int, stop: int, unit: float) -> bool:
    """Whether a parabola with the slopes beside rows start to stop goes beyond their level, and the rest moves on."""
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
    return bool((before + after) * (length + 1) / 8 > OVERSHOOT * unit and moved > 0.3 * slope * length)


def spikes(values: Array, steps: Array | None = None, gaps: NDArray[np.intp] | None = None) -> Mask:
    """Single wrong values (n, k) in values (n, k): far from the cubic through two neighbours on either side.

    e_i = v_i - (4 (v_{i-1} + v_{i+1}) - v_{i-2} - v_{i+2}) / 6

    A spike's e is SPIKE_SIGMAS local standard deviations; its neighbours' e have the other sign and two thirds of it,
    and the neighbours agree with each other: a jump or a rough stretch is none. steps : (k,) least significant bits, a
    floor to the noise. gaps : samples after which a gap follows; the two on either side of it are not judged.
    """
    found = np.zeros(values.shape, np.bool_)
    if len(values) < 8:
        return found
    floor = np.zeros(values.shape[1]) if steps is None else 0.4 * steps
    for axis, column in enumerate(values.T):
        found[_single(column, float(floor[axis])), axis] = True
    if gaps is not None and len(gaps):
        found[np.clip(gaps[:, None] + np.arange(-1, 3), 0, len(values) - 1).ravel()] = False
    return found


def _single(column: Array, floor: float) -> NDArray[np.intp]:
    """Indices of the spikes of one axis (n,)."""
    e = column[2:-2] - (4 * (column[1:-3] + column[3:-1]) - column[:-4] - column[4:]) / 6
    size = np.abs(e)
    std = np.maximum(_local_std(size), floor)
    large = np.flatnonzero(size[1:-1] > SPIKE_SIGMAS * std[1:-1]) + 1
    height, at = size[large], large + 2
    highest = height > 1.2 * np.maximum(size[large - 1], size[large + 1])
    opposite = np.minimum(-np.sign(e[large]) * e[large - 1], -np.sign(e[large]) * e[large + 1]) > 0.2 * height
    slopes = column[at + 1] - column[at - 1], column[at - 1] - column[at - 2] + column[at + 2] - column[at + 1]
    agreed = np.abs(slopes[0] - slopes[1]) / 2 < np.maximum(SLOPE_TOLERANCE * height, 3 * std[large])
    return np.asarray(at[highest & opposite & agreed], np.intp)


def _local_std(size: Array) -> Array:
    """Robust standard deviation (n,) of an error of size (n,): of all of it, or of its surroundings where larger."""
    overall = np.median(size) / 0.6745
    blocks = max(len(size) // NOISE_WINDOW, 1)
    parts = np.array_split(size, blocks)
    local = np.array([np.median(part) for part in parts]) / 0.6745
    widest = np.maximum(local, np.maximum(np.r_[local[1:], 0], np.r_[0, local[:-1]]))
    return np.asarray(np.maximum(np.repeat(widest, [len(part) for part in parts]), overall))
