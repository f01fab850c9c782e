"""The value lattice of a converter: its least significant bit, found in the values alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array

LEAST_CODES = 4
"""Distinct values below which a step cannot be checked."""
ON_LATTICE_STEPS = 0.2
"""Distance from the lattice, in steps, within which a value counts as on it."""
LEAST_SHARE = 0.85
CHANCE = 1e-9
"""Largest probability that values without a lattice would lie so close to one."""
SINGLE_PRECISION = 2.0**-22
"""A step below this fraction of the largest value can be the storage's: single precision resolves 2^-24 to 2^-23."""
LEAST_LARGE = 16
"""Values on either side that tell floating-point steps."""
GROUP, LEAST_GROUPS, LEAST_IN_GROUP = 8, 8, 40
PREFERRED, SAME_SIDE = 0.1, 0.9
"""How far the share of odd codes is from a half, and in how many groups on the same side, to be a preference."""
MOST_DIFFERENCES = 400
GCD_TOLERANCES = (1e-6, 1e-3, 2e-2)
"""Remainders, as fractions of the smallest difference, that a common divisor takes for rounding."""


@dataclass(frozen=True)
class Lattice:
    """values = offset + step * integer, but for `scatter` (rms, in steps), for `share` of the values.

    codes : distinct integers seen.
    floating : the steps grow with the value, as those of a floating-point number: storage, not a converter.
    """

    step: float
    offset: float
    share: float
    scatter: float
    codes: int
    floating: bool


def find_lattice(values: Array) -> Lattice | None:
    """The coarsest lattice on which values (n,) lie, or None; values that are not finite are left out.

    Candidates for the step are common divisors of the differences between neighbouring distinct values, their jumps
    and their most frequent size; each is refined over windows that grow fourfold and must leave a scatter that values
    without a lattice reach with a probability below CHANCE. Rounding by later arithmetic does no harm.
    """
    values = values[np.isfinite(values)]
    distinct = _distinct(values)
    if len(distinct) < LEAST_CODES:
        return None
    steps = sorted(_candidates(np.diff(distinct), float(np.abs(distinct).max())), reverse=True)
    for step in steps:
        found = _checked(distinct, values, step, len(steps))
        if found is not None:
            return found
    return None


def _distinct(values: Array) -> Array:
    """The distinct values, sorted; those alone that occur again where they are nearly all, so that strays drop out."""
    distinct, counts = np.unique(values, return_counts=True)
    again = counts > 1
    usual = np.count_nonzero(again) >= LEAST_CODES and counts[again].sum() >= LEAST_SHARE * len(values)
    return distinct[again] if usual else distinct


def odd_share(codes: NDArray[np.int64]) -> float:
    """Share of odd ones among integer codes (n,), 0.5 unless one kind is preferred throughout; 0.5 where few codes.

    The codes are taken in groups of GROUP neighbours, which differ in height little; a preference must show in nearly
    all of them and make one kind half as frequent again as the other.
    """
    first = int(codes.min(initial=0)) // GROUP * GROUP
    counts = np.bincount(codes - first)
    groups = np.pad(counts, (0, -len(counts) % GROUP)).reshape(-1, GROUP)
    full = groups[groups.sum(axis=1) >= LEAST_IN_GROUP]
    if len(full) < LEAST_GROUPS:
        return 0.5
    shares = full[:, 1::2].sum(axis=1) / full.sum(axis=1)
    share = float(full[:, 1::2].sum() / full.sum())
    same = np.mean((shares > 0.5) == (share > 0.5))
    return share if abs(share - 0.5) > PREFERRED and same >= SAME_SIDE else 0.5


def _candidates(gaps: Array, size: float) -> list[float]:
    floor = 64 * np.finfo(float).eps * size
    ordered = np.sort(gaps[gaps > floor])
    if len(ordered) < LEAST_CODES - 1:
        return []
    steps = [_common_divisor(ordered, tolerance) for tolerance in GCD_TOLERANCES]
    steps += [*_jumps(ordered, gaps), *_most_frequent(ordered)]
    return [step for step in dict.fromkeys(steps) if step > floor]


def _common_divisor(ordered: Array, tolerance: float) -> float:
    """Greatest common divisor of the smallest differences, remainders below the tolerance taken for zero."""
    divisor = float(ordered[0])
    limit = tolerance * divisor
    other = ordered[1:][np.diff(ordered) > limit]
    for value in other[:MOST_DIFFERENCES]:
        rest = float(value)
        while abs(rest) > limit:
            divisor, rest = abs(rest) if abs(rest) < divisor else divisor, rest - round(rest / divisor) * divisor
    return divisor


def _jumps(ordered: Array, gaps: Array) -> Iterator[float]:
    """Where the sorted differences jump, from rounding to whole steps: the usual distance between cluster means."""
    ratio = ordered[1:] / ordered[:-1]
    jumps = np.flatnonzero(ratio > 2)
    for index in {*jumps[np.argsort(ratio[jumps])[-4:]].tolist(), *jumps[-4:].tolist()}:
        starts = np.r_[0, np.flatnonzero(gaps >= ordered[index + 1]) + 1]
        place = np.r_[0.0, np.cumsum(gaps)]
        means = np.add.reduceat(place, starts) / np.diff(np.r_[starts, len(place)])
        between = np.diff(means)
        yield float(np.median(between[between <= 1.5 * between.min()]))


def _most_frequent(ordered: Array) -> Iterator[float]:
    """The tightest cluster of differences, and its simple parts."""
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
    codes = np.unique(code[off < ON_LATTICE_STEPS])
    spread = max(float(np.quantile(off, LEAST_SHARE)), 1e-12)
    if spread > ON_LATTICE_STEPS or (len(codes) - 3) * _surprise(2 * spread) < np.log(tried / CHANCE):
        return None
    factor = float(np.gcd.reduce((codes - codes[0]).astype(np.int64))) or 1.0
    step *= factor
    place = (values - offset) / step
    off = place - np.rint(place)
    on = np.abs(off) < ON_LATTICE_STEPS
    share, scatter = float(on.mean()), float(np.sqrt(np.mean(off[on] ** 2)))
    return Lattice(step, float(offset), share, scatter, len(codes), _is_floating(distinct, step))


def _surprise(chance: float) -> float:
    """Nats a value that LEAST_SHARE of the values lie where one does with this chance: their divergence."""
    rest = 1.0 - LEAST_SHARE
    return float(LEAST_SHARE * np.log(LEAST_SHARE / chance) + rest * np.log(rest / (1.0 - chance)))


def _refined(distinct: Array, step: float) -> tuple[float, float] | None:
    """Step and offset, fitted in growing windows about the median so that no code slips."""
    middle = float(distinct[len(distinct) // 2])
    distance = np.abs(distinct - middle)
    reach = max(20 * step, float(np.sort(distance)[min(10, len(distance) - 1)]))
    offset = middle
    while True:
        inside = distinct[distance <= reach]
        turn = np.angle(np.mean(np.exp(2j * np.pi * (inside - offset) / step))) / (2 * np.pi)
        offset += turn * step
        code = np.rint((inside - offset) / step)
        on = np.abs(inside - offset - code * step) < ON_LATTICE_STEPS * step
        if np.count_nonzero(on) < max(3, 0.8 * len(inside)) or np.ptp(code[on]) == 0:
            return None
        x, y = code[on] - code[on].mean(), inside[on]
        step = float(x @ (y - y.mean()) / (x @ x))
        offset = float(y.mean() - step * code[on].mean())
        if len(inside) == len(distinct):
            return step, offset
        reach *= 4


def _is_floating(distinct: Array, step: float) -> bool:
    """Whether large values skip codes that small ones use, in a binary or a decimal way, or the step is storage's."""
    size = np.abs(distinct)
    large, small = distinct[size > size.max() / 2], distinct[size < size.max() / 20]
    if len(large) >= LEAST_LARGE and len(small) >= LEAST_LARGE:
        skips = (base for base in (4, 10) if _all_on(large, base * step) and not _all_on(small, base * step))
        if next(skips, None):
            return True
    return SINGLE_PRECISION / 4 < step / float(size.max()) <= SINGLE_PRECISION / 2 * 1.001


def _all_on(values: Array, step: float) -> bool:
    """Whether all values are multiples of a step."""
    place = values / step
    return bool(np.all(np.abs(place - np.rint(place)) < ON_LATTICE_STEPS / 4))
