"""Rows of a log for the comparison of axes: a few thousand, averaged where the log is fast, in contiguous pieces."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array
from validation.axes.policy import AXES


@dataclass(frozen=True)
class AxisRows:
    """Times (n,), field (n, 3) less the mean and over the spread, another vector (n, k), and the piece (n,) of a row.

    spread_nT : rms deviation of the field from its mean, per component.
    """

    time_s: Array
    mag: Array
    other: Array
    piece: NDArray[np.intp]
    spread_nT: float

    @property
    def interval_s(self) -> float:
        """Return the median interval."""
        return float(np.median(np.diff(self.time_s)))

    @property
    def step(self) -> int:
        """Return the rows after which the field has changed by a good part of its spread."""
        step, most = 1, max(1, min(int(AXES.longest_window_s / self.interval_s), len(self.mag) // (2 * AXES.pieces)))
        while step < most and np.sqrt(np.mean((self.mag[step:] - self.mag[:-step]) ** 2)) < AXES.turn_share:
            step *= 2
        return min(step, most)


def rows_of(time_s: Array, mag_nT: Array, other: Array, *, averaged: bool) -> AxisRows | None:
    """Return rows in which field and the other vector are finite; None for too few, or a constant field."""
    sound = np.flatnonzero(np.isfinite(mag_nT).all(axis=1) & np.isfinite(other).all(axis=1))
    if len(sound) < AXES.least_rows:
        return None
    columns = np.column_stack([time_s, mag_nT, other])[_picked(sound, time_s, averaged)]
    width = min(_width(columns[:, 0], averaged), len(columns) // AXES.least_rows)
    if width > 1:
        kept = len(columns) // width * width
        columns = columns[:kept].reshape(-1, width, columns.shape[1]).mean(axis=1)
    mag = columns[:, 1:4] - columns[:, 1:4].mean(axis=0)
    spread_nT = float(np.sqrt(np.mean(mag**2)))
    if not spread_nT > 0:
        return None
    piece = np.arange(len(columns)) * AXES.pieces // len(columns)
    return AxisRows(columns[:, 0], mag / spread_nT, columns[:, 4:], piece, spread_nT)


def _picked(sound: NDArray[np.intp], time_s: Array, averaged: bool) -> NDArray[np.intp]:
    """Return the sound rows, or contiguous stretches of a log with too many rows."""
    most = AXES.most_rows * (_width(time_s[sound], averaged))
    if len(sound) <= most:
        return sound
    if not averaged:
        return sound[:: -(-len(sound) // most)]
    length = most // AXES.pieces
    starts = np.linspace(0, len(sound) - length, AXES.pieces).astype(int)
    return sound[(starts[:, None] + np.arange(length)).ravel()]


def _width(time_s: Array, averaged: bool) -> int:
    """Return the number of rows in a mean."""
    interval_s = float(np.median(np.diff(time_s)))
    return max(1, int(AXES.mean_s / interval_s)) if averaged and interval_s > 0 else 1


def piece_moments(functions: Array, piece: NDArray[np.intp]) -> Array:
    """Return the second moments (pieces, f, f) of functions (n, f) in each piece of a log; piece (n,) ascending."""
    edges = np.searchsorted(piece, np.arange(AXES.pieces + 1))
    return np.array([functions[a:b].T @ functions[a:b] for a, b in pairwise(edges)])
