"""Legs of a recording: what is held out in turn, so that a model is asked of what it has not seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from recordings import Recording
from scenarios.arrays import Array

LEAST_LEGS = 6
"""Fewer phases or headings than these are no legs to hold out, and from fewer blocks nothing is told: with five the
t interval is wider than twice the spread of a leg."""
BLOCKS = 20
"""Parts of a recording without legs of its own: as long as may be, so that slow noise is not the same on either side
of a cut, and enough to know their spread to 16 %."""
MOST_LEGS = 40
"""Where there are more, neighbours are held out together."""
SECTORS = 8
"""Of the heading: a leg ends where it has left its sector, by half a sector more."""
STEADY_DEG, STEADY_SHARE = 10.0, 0.6
"""Legs are straight where this share of the samples is as near to its leg's middle heading; in a steady turn over a
sector and its margins it is a quarter."""


@dataclass(frozen=True, eq=False)
class LegPartition:
    """The leg of each sample (n,), counted from 0, and how they were found, for a sentence."""

    number: NDArray[np.intp]
    how: str

    @property
    def count(self) -> int:
        """How many there are."""
        return int(self.number[-1]) + 1

    @property
    def sizes(self) -> NDArray[np.intp]:
        """Samples of each (count,)."""
        return np.bincount(self.number)

    def squares(self, rows: Array) -> Array:
        """Of rows (n, r, k) each leg's sum of squares (legs, k, k)."""
        ends = np.flatnonzero(np.diff(self.number)) + 1
        parts = (part.reshape(-1, rows.shape[2]) for part in np.split(rows, ends))
        return np.array([part.T @ part for part in parts])


def legs_of(recording: Recording) -> LegPartition:
    """The stretches of one phase, else of one heading, where there are enough of them; else equal blocks of time."""
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
    """At most so many: neighbours as one."""
    count = int(number[-1]) + 1
    return number if count <= MOST_LEGS else number * MOST_LEGS // count


def _runs(labels: NDArray[np.generic]) -> NDArray[np.intp]:
    """The number of the run of equal labels that each sample is in."""
    return np.concatenate(([0], np.cumsum(labels[1:] != labels[:-1])))


def _straight(att_q: Array) -> NDArray[np.intp] | None:
    """Runs of a heading; None where the vehicle turns most of the time."""
    forward = Rotation.from_quat(att_q, scalar_first=True).apply([1.0, 0.0, 0.0])
    heading = np.unwrap(np.arctan2(forward[:, 1], forward[:, 0])) / (2.0 * np.pi / SECTORS)
    runs = _runs(_held(heading))
    middle = np.array([np.median(part) for part in np.split(heading, np.flatnonzero(np.diff(runs)) + 1)])
    off_deg = np.abs(heading - middle[runs]) * 360.0 / SECTORS
    return runs if np.mean(off_deg < STEADY_DEG) >= STEADY_SHARE else None


def _held(heading: Array) -> Array:
    """The sector of each heading, both in sectors; one is left where its margin of half a sector is."""
    held, now = np.empty(len(heading)), np.round(heading[0])
    for i, value in enumerate(heading):
        if abs(value - now) > 1.0:
            now = np.round(value)
        held[i] = now
    return held
