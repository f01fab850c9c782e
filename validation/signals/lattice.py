"""Least significant bit of a converter: the lattice of its values, found from the values alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array
from validation.policy import POLICY

SINGLE_PRECISION = 2.0**-22
"""Twice the coarsest relative resolution of single precision, which is 2^-24 to 2^-23 of the value."""
GROUP = 8
"""Neighbouring codes whose counts are compared: they differ little in height."""
SAME_DISTANCE = 1.5
"""Ratio to the least distance of clusters up to which a distance counts as one step."""
MOST_DIFFERENCES = 400
"""Differences at most that a common divisor is computed from."""
NEAREST = 10
"""Neighbours of the median that the first window holds at least."""
GCD_TOLERANCES = (1e-6, 1e-3, 2e-2)
"""Remainders, over the smallest difference, that count as rounding in a common divisor."""


@dataclass(frozen=True)
class Lattice:
    """Lattice ``values = offset + step * integer`` within `scatter` (rms, in steps), for `share` of the values.

    codes : distinct integers seen.
    floating : the step grows with the value as in a floating-point number: storage, not a converter.
    """

    step: float
    offset: float
    share: float
    scatter: float
    codes: int
    floating: bool


def find_lattice(values: Array) -> Lattice | None:
    """Return the coarsest lattice of values (n,), or None; values that are not finite are left out.

    Candidates for the step are common divisors of the differences of neighbouring distinct values, jumps in the sorted
    differences, and the most frequent difference. Each candidate is refined over windows that grow fourfold. The
    scatter must have a probability below 1e-9 for values without a lattice. Rounding by later arithmetic is tolerated.
    """
    values = values[np.isfinite(values)]
    distinct = _distinct(values)
    if len(distinct) < POLICY.least_codes:
        return None
    steps = sorted(_candidates(np.diff(distinct), float(np.abs(distinct).max())), reverse=True)
    for step in steps:
        found = _checked(distinct, values, step, len(steps))
        if found is not None:
            return found
    return None


def _distinct(values: Array) -> Array:
    """Return sorted distinct values; without single values, which may be strays, where most values repeat."""
    distinct, counts = np.unique(values, return_counts=True)
    again = counts > 1
    usual = counts[again].sum() >= POLICY.least_on_lattice * len(values)
    return distinct[again] if usual and np.count_nonzero(again) >= POLICY.least_codes else distinct


def odd_share(codes: NDArray[np.int64]) -> float:
    """Return the share of odd values among integer codes (n,); 0.5 for few codes or without a preference.

    Codes are counted in groups of GROUP neighbours. A preference needs a share of 0.4 or less, or 0.6 or more, and the
    same sign in nine of ten groups.
    """
    _, group = np.unique(codes // GROUP, return_inverse=True)  # of codes that are there: two may lie 1e9 apart
    counts, odd = np.bincount(group), np.bincount(group, weights=codes % 2)
    full = counts >= POLICY.least_in_group
    if np.count_nonzero(full) < POLICY.least_groups:
        return 0.5
    shares = odd[full] / counts[full]
    share = float(odd[full].sum() / counts[full].sum())
    same = np.mean((shares > 0.5) == (share > 0.5))
    return share if abs(share - 0.5) > POLICY.preferred and same >= POLICY.same_side else 0.5


def _candidates(gaps: Array, size: float) -> list[float]:
    floor = 64 * np.finfo(float).eps * size
    ordered = np.sort(gaps[gaps > floor])
    if len(ordered) < POLICY.least_codes - 1:
        return []
    steps = [_common_divisor(ordered, tolerance) for tolerance in GCD_TOLERANCES]
    steps += [*_jumps(ordered, gaps), *_most_frequent(ordered)]
    return [step for step in dict.fromkeys(steps) if step > floor]


def _common_divisor(ordered: Array, tolerance: float) -> float:
    """Return the greatest common divisor of the smallest differences; remainders below the tolerance are zero."""
    divisor = float(ordered[0])
    limit = tolerance * divisor
    other = ordered[1:][np.diff(ordered) > limit]
    for value in other[:MOST_DIFFERENCES]:
        rest = float(value)
        while abs(rest) > limit:
            divisor, rest = abs(rest) if abs(rest) < divisor else divisor, rest - round(rest / divisor) * divisor
    return divisor


def _jumps(ordered: Array, gaps: Array) -> Iterator[float]:
    """Yield distances of cluster means, with clusters parted where the sorted differences jump twofold."""
    ratio = ordered[1:] / ordered[:-1]
    jumps = np.flatnonzero(ratio > 2)
    for index in {*jumps[np.argsort(ratio[jumps])[-4:]].tolist(), *jumps[-4:].tolist()}:
        starts = np.r_[0, np.flatnonzero(gaps >= ordered[index + 1]) + 1]
        place = np.r_[0.0, np.cumsum(gaps)]
        means = np.add.reduceat(place, starts) / np.diff(np.r_[starts, len(place)])
        between = np.diff(means)
        yield float(np.median(between[between <= SAME_DISTANCE * between.min()]))


def _most_frequent(ordered: Array) -> Iterator[float]:
    """Yield the middle of the tightest cluster of differences, one half and one third of the middle."""
    width = max(3, len(ordered) // 20)
    if len(ordered) > width:
        first = int(np.argmin(ordered[width:] / ordered[:-width]))
        size = float(np.median(ordered[first : first + width + 1]))
        yield from (size, size / 2, size / 3)


def _checked(distinct: Array, values: Array, step: float, tried: int) -> Lattice | None:
    fit = _refined(distinct, step)
    if fit is None:
        return None
    step, offset = fit
    place = (distinct - offset) / step
    code = np.rint(place)
    off = np.abs(place - code)
    codes = np.unique(code[off < POLICY.on_lattice])
    spread = max(float(np.quantile(off, POLICY.least_on_lattice)), 1e-12)
    if spread > POLICY.on_lattice or (len(codes) - 3) * _surprise(2 * spread) < np.log(tried / POLICY.lattice_alarm):
        return None
    factor = float(np.gcd.reduce((codes - codes[0]).astype(np.int64))) or 1.0
    step *= factor
    place = (values - offset) / step
    off = place - np.rint(place)
    on = np.abs(off) < POLICY.on_lattice
    share, scatter = float(on.mean()), float(np.sqrt(np.mean(off[on] ** 2)))
    return Lattice(step, float(offset), share, scatter, len(codes), _is_floating(distinct, step))


def _surprise(chance: float) -> float:
    """Return the Kullback-Leibler divergence in nats a value: share required on the lattice against chance."""
    p = POLICY.least_on_lattice
    rest = 1.0 - p
    return float(p * np.log(p / chance) + rest * np.log(rest / (1.0 - chance)))


def _refined(distinct: Array, step: float) -> tuple[float, float] | None:
    """Return step and offset, fitted in growing windows about the median so that no code slips."""
    middle, reach = _middle(distinct)
    reach = max(20 * step, reach)
    offset = middle
    while True:
        first, last = np.searchsorted(distinct, middle - reach), np.searchsorted(distinct, middle + reach, "right")
        inside = distinct[first:last]
        turn = np.angle(np.mean(np.exp(2j * np.pi * (inside - offset) / step))) / (2 * np.pi)
        offset += turn * step
        code = np.rint((inside - offset) / step)
        on = np.abs(inside - offset - code * step) < POLICY.on_lattice * step
        if np.count_nonzero(on) < max(3, POLICY.least_in_window * len(inside)) or np.ptp(code[on]) == 0:
            return None
        x, y = code[on] - code[on].mean(), inside[on]
        step = float(x @ (y - y.mean()) / (x @ x))
        offset = float(y.mean() - step * code[on].mean())
        if len(inside) == len(distinct):
            return step, offset
        reach *= 4


def _middle(distinct: Array) -> tuple[float, float]:
    """Return the median of sorted values, and the distance within which its nearest neighbours lie."""
    at = len(distinct) // 2
    middle = float(distinct[at])
    nearest = np.sort(np.abs(distinct[max(0, at - NEAREST) : at + NEAREST + 1] - middle))
    return middle, float(nearest[min(NEAREST, len(distinct) - 1)])


def _is_floating(distinct: Array, step: float) -> bool:
    """Return whether large values skip codes by a factor of 4 or 10, or the step is that of single precision."""
    size = np.abs(distinct)
    large, small = distinct[size > size.max() / 2], distinct[size < size.max() / POLICY.small_values]
    skips = (_all_on(large, base * step) and not _all_on(small, base * step) for base in (4, 10))
    if min(len(large), len(small)) >= POLICY.least_large and any(skips):
        return True
    finest, coarsest = SINGLE_PRECISION / 4, SINGLE_PRECISION / 2 * 1.001
    return finest < step / float(size.max()) <= coarsest


def _all_on(values: Array, step: float) -> bool:
    """Return whether all values are multiples of a step."""
    place = values / step
    return bool(np.all(np.abs(place - np.rint(place)) < POLICY.on_coarse_lattice))
