"""Legs of a recording, held out in turn for cross-validation."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from recordings import Recording
from scenarios.arrays import Array

LEAST_LEGS = 6
"""Least number of legs; with five blocks the t interval is wider than twice the spread of a leg."""
BLOCKS = 20
"""Blocks of a recording without phases and headings: long, so that slow noise differs between blocks, and enough to
know the spread to 16 %."""
MOST_LEGS = 40
"""Legs at most; of more legs neighbours are held out together."""
SECTORS = 8
"""Sectors of the heading; a leg ends half a sector beyond the sector's edge."""
STEADY_DEG, STEADY_SHARE = 10.0, 0.6
"""Legs are straight if 60 % of the samples are within 10 degrees of the leg's median heading; in a steady turn over a
sector and margins the share is a quarter."""


BLOCK = 4096
"""Samples whose rows are in memory at a time; they fit the processor's cache."""


@dataclass(frozen=True, eq=False)
class LegPartition:
    """Number of the leg of each sample (n,), from 0, and the kind of legs in words."""

    number: NDArray[np.intp]
    how: str

    @property
    def count(self) -> int:
        """Return the number of legs."""
        return int(self.number[-1]) + 1

    @property
    def sizes(self) -> NDArray[np.intp]:
        """Return the samples of each leg (count,)."""
        return np.bincount(self.number)

    def squares(self, rows: Callable[[slice], Array]) -> Array:
        """Return the sum of squares (legs, k, k) in each leg of the rows (m, r, k) that a part of the samples has."""
        ends = [0, *(np.flatnonzero(np.diff(self.number)) + 1), len(self.number)]
        return np.array([np.sum([_square(rows(block)) for block in _blocks(*leg)], axis=0) for leg in pairwise(ends)])


def _blocks(first: int, end: int) -> Iterator[slice]:
    return (slice(start, min(start + BLOCK, end)) for start in range(first, end, BLOCK))


def _square(rows: Array) -> Array:
    flat = rows.reshape(-1, rows.shape[2])
    return np.asarray(flat.T @ flat)


def legs_of(recording: Recording) -> LegPartition:
    """Return stretches of equal phase, or of equal heading, if there are enough; else equal blocks of time."""
    runs = {
        "phases": None if recording.phase is None else _runs(np.asarray(recording.phase)),
        "headings": None if recording.att_q is None else _straight(recording.att_q),
    }
    for how, number in runs.items():
        if number is not None and number[-1] + 1 >= LEAST_LEGS:
            return LegPartition(_joined(number), how)
    n = len(recording)
    return LegPartition(np.arange(n) * min(BLOCKS, n) // n, "blocks of time")


def _joined(number: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return at most MOST_LEGS legs, neighbours joined."""
    count = int(number[-1]) + 1
    return number if count <= MOST_LEGS else number * MOST_LEGS // count


def _runs(labels: NDArray[np.generic]) -> NDArray[np.intp]:
    """Return the run of equal labels of each sample."""
    return np.concatenate(([0], np.cumsum(labels[1:] != labels[:-1])))


def _straight(att_q: Array) -> NDArray[np.intp] | None:
    """Return runs of equal heading, None if the vehicle turns most of the time."""
    forward = Rotation.from_quat(att_q, scalar_first=True).apply([1.0, 0.0, 0.0])
    heading = np.unwrap(np.arctan2(forward[:, 1], forward[:, 0])) / (2.0 * np.pi / SECTORS)
    runs = _runs(_held(heading))
    middle = np.array([np.median(part) for part in np.split(heading, np.flatnonzero(np.diff(runs)) + 1)])
    off_deg = np.abs(heading - middle[runs]) * 360.0 / SECTORS
    return runs if np.mean(off_deg < STEADY_DEG) >= STEADY_SHARE else None


def _held(heading: Array) -> Array:
    """Return the sector of each heading (in sectors), with a hysteresis of half a sector."""
    held, now = np.empty(len(heading)), np.round(heading[0])
    for i, value in enumerate(heading):
        if abs(value - now) > 1.0:
            now = np.round(value)
        held[i] = now
    return held
