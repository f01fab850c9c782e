"""Streams of several rates brought to a magnetometer's times: between neighbouring samples, never across a gap.

A log holds several streams: the magnetometer at 50 Hz, attitude at 25 Hz, battery current at 5 Hz, the flight mode at
each change. `merge` gives every column a value at each time of the magnetometer, or NaN where the stream is silent.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array

MAX_GAP_INTERVALS = 5.0
"""A stretch without samples that is longer than this multiple of the stream's own interval is an outage."""
MAGNETOMETER = "magnetometer"
"""The magnetometer's name among the streams, in counts and notes."""
NUMBERS = "fiub"
"""numpy's kinds of numbers; words are of kind U."""
Values = NDArray[Any]
Rows = NDArray[np.int64]


class Interpolation(StrEnum):
    """How a column is carried from its own times t_i to a time t, with u = (t - t_i) / (t_i+1 - t_i) in [0, 1].

    The error bounds hold for a quantity f(t) sampled without noise at the interval h.
    """

    LINEAR = "linear"
    """(1 - u) x_i + u x_i+1, within h^2 / 8 max|f''|; noise of variance s^2 becomes ((1 - u)^2 + u^2) s^2."""
    HELD = "held"
    """x_i, the last sample: for steps and labels that last until the next sample, such as flight modes."""
    NEAREST = "nearest"
    """x_i for u < 1/2, else x_i+1: for steps and labels sampled at a rate, within h / 2 max|f'|."""
    ANGLE_DEG = "angle, degrees"
    """Linear, after whole turns are added so that neighbours differ by at most 180 degrees; may leave [0, 360]."""
    ANGLE_RAD = "angle, radians"
    """Linear, after whole turns are added so that neighbours differ by at most pi; may leave [-pi, pi]."""
    SLERP = "spherical"
    """Quaternions w x y z on the shorter arc at constant rate, see `_spherical`; exact for a constant body rate."""
    CHORD = "chord"
    """Quaternions w x y z on the chord of the shorter arc, normalised: within 0.0040 theta^3 rad of SLERP, theta the
    turn between the samples in rad. Files whose rows are merged already are filled so."""


PERIODS = {Interpolation.ANGLE_DEG: 360.0, Interpolation.ANGLE_RAD: 2 * math.pi}
QUATERNIONS = (Interpolation.SLERP, Interpolation.CHORD)
STEPS = (Interpolation.HELD, Interpolation.NEAREST)


@dataclass(frozen=True, eq=False)
class Stream:
    """Samples of one or several columns at common times.

    Parameters
    ----------
    times_s : (n,) times of the samples on the log's clock; may repeat or go backwards.
    columns : name -> (n,) numbers, NaN where a sample lacks the value, or words, empty where it does.
    interpolation : name -> how the column is carried, LINEAR for columns that are not listed. Words need HELD or
        NEAREST. SLERP or CHORD is listed for all four components w x y z of a quaternion, in the order of `columns`;
        a stream holds at most one quaternion.
    max_gap_intervals : a longer stretch between two samples, in multiples of the median interval, is a gap; infinity
        for events that last until the next event.
    """

    times_s: Array
    columns: Mapping[str, Values]
    interpolation: Mapping[str, Interpolation] = field(default_factory=dict)
    max_gap_intervals: float = MAX_GAP_INTERVALS

    def __post_init__(self) -> None:
        """Raise ValueError for columns of another length, and for an interpolation that does not fit its columns."""
        lengths = {name: len(values) for name, values in self.columns.items() if len(values) != len(self.times_s)}
        if lengths:
            raise ValueError(f"{len(self.times_s)} times, but columns of other lengths: {lengths}")
        unknown = sorted(set(self.interpolation) - set(self.columns))
        if unknown:
            raise ValueError(f"interpolation of columns that are not there: {', '.join(unknown)}")
        for names, how in self.groups.items():
            if (how in QUATERNIONS) != (len(names) == 4):
                raise ValueError(f"{how} needs the four columns w x y z, found {', '.join(names)}")
            if how not in STEPS and any(self.columns[name].dtype.kind not in NUMBERS for name in names):
                raise ValueError(f"{names[0]} holds words, which are held or nearest, not {how}")

    @property
    def groups(self) -> dict[tuple[str, ...], Interpolation]:
        """The columns that are interpolated together, a quaternion's four or a column alone, and how."""
        carried = {name: self.interpolation.get(name, Interpolation.LINEAR) for name in self.columns}
        quaternion = tuple(name for name, how in carried.items() if how in QUATERNIONS)
        return {quaternion if name in quaternion else (name,): how for name, how in carried.items()}


@dataclass(frozen=True)
class RemovedRows:
    """Rows of a stream that have no place in an increasing time, counted by the reason for their removal."""

    without_time: int = 0
    repeated: int = 0
    backwards: int = 0

    @property
    def total(self) -> int:
        """The number of rows removed."""
        return self.without_time + self.repeated + self.backwards


@dataclass(frozen=True, eq=False)
class MergedStreams:
    """Columns of several streams at a magnetometer's times.

    Parameters
    ----------
    columns : name -> (m,): `time_s`, increasing, the magnetometer's columns as measured, and every column of the other
        streams, NaN or an empty word where the stream has a gap or does not reach. A column of another stream without
        any value at these times is left out.
    removed : by the name of a stream, the rows that were removed; streams without such rows are not listed.
    missing : by the name of a column of another stream, at how many of the m times the column has no value; complete
        columns are not listed.
    """

    columns: dict[str, Values]
    removed: dict[str, RemovedRows]
    missing: dict[str, int]

    @property
    def notes(self) -> tuple[str, ...]:
        """A line for each stream with removed rows and for each column with missing values."""
        removed = (
            f"{name}: {rows.total} rows removed: {rows.without_time} without a time, {rows.repeated} with a repeated "
            f"time, {rows.backwards} against the order of time"
            for name, rows in self.removed.items()
        )
        times = len(self.columns["time_s"])
        return (*removed, *(f"{name}: no value at {count} of {times} times" for name, count in self.missing.items()))


def merge(magnetometer: Stream, others: Mapping[str, Stream]) -> MergedStreams:
    """Bring streams, by name, to the times of a magnetometer.

    The magnetometer's own columns stay as measured. Several magnetometers with times of their own are merged in one
    call each; within a call a second magnetometer is a stream like any other.
    Raises ValueError for a column that two streams have.
    """
    ordered = {name: ordered_rows(stream.times_s) for name, stream in {MAGNETOMETER: magnetometer, **others}.items()}
    rows = ordered[MAGNETOMETER][0]
    columns = {"time_s": magnetometer.times_s[rows], **{name: x[rows] for name, x in magnetometer.columns.items()}}
    missing: dict[str, int] = {}
    for stream_name, stream in others.items():
        for name, values in _carried(columns["time_s"], stream, ordered[stream_name][0]).items():
            if name in columns or name in missing:
                raise ValueError(f"the stream {stream_name} has a column {name}, as does another stream")
            missing[name] = int(np.count_nonzero(_is_missing(values)))
            columns |= {name: values} if missing[name] < len(rows) else {}
    return MergedStreams(
        columns,
        removed={name: removed for name, (_, removed) in ordered.items() if removed.total},
        missing={name: count for name, count in missing.items() if count},
    )


def interpolated(at_s: Array, times_s: Array, values: Values, how: Interpolation) -> Values:
    """Return values (n, k), n >= 1, of increasing times (n,) at times (m,): (m, k); constant beyond the ends."""
    if how in STEPS:
        switch_s = times_s if how is Interpolation.HELD else np.r_[-np.inf, (times_s[1:] + times_s[:-1]) / 2]
        return np.asarray(values[np.maximum(np.searchsorted(switch_s, at_s, "right") - 1, 0)])
    nodes = _same_sign(values) if how in QUATERNIONS else values
    if how is Interpolation.SLERP:
        return _spherical(at_s, times_s, nodes)
    if how in PERIODS:
        nodes = np.unwrap(nodes, axis=0, period=PERIODS[how])
    between = np.column_stack([np.interp(at_s, times_s, node) for node in nodes.T])
    return between / np.linalg.norm(between, axis=1, keepdims=True) if how is Interpolation.CHORD else between


def covered(at_s: Array, times_s: Array, how: Interpolation, max_gap_s: float) -> NDArray[np.bool_]:
    """Return whether samples at increasing times (n,) support a value at times (m,): (m,).

    With the age t - t_i of the last sample and the wait t_i+1 - t for the next sample: age + wait <= max_gap between
    two samples, age <= max_gap for a held value, min(age, wait) <= max_gap / 2 for the nearest. At a sample's own time
    age = wait = 0. Before the first sample the age is infinite, after the last sample the wait.
    """
    edges_s = np.r_[-np.inf, times_s, np.inf]
    age_s = at_s - edges_s[np.searchsorted(times_s, at_s, "right")]
    wait_s = edges_s[np.searchsorted(times_s, at_s, "left") + 1] - at_s
    nearest_s = 2 * np.minimum(age_s, wait_s)
    span_s = {Interpolation.HELD: age_s, Interpolation.NEAREST: nearest_s}.get(how, age_s + wait_s)
    return np.asarray(np.isfinite(span_s) & (span_s <= max_gap_s))


def own_interval_s(times_s: Array) -> float:
    """Return the median interval of increasing times (n,); 0 for fewer than two times."""
    return float(np.median(np.diff(times_s))) if len(times_s) > 1 else 0.0


def ordered_rows(times_s: Array) -> tuple[Rows, RemovedRows]:
    """Return the rows (m,) of a longest strictly increasing subsequence of times (n,), and counts of the other rows.

    The fewest rows are removed: a single wrong time costs one row, whether the time jumps back or ahead, and after a
    reset of the clock the longer part stays, where sorting would interleave both parts. Of rows with a repeated time
    the last stays.
    """
    finite = np.flatnonzero(np.isfinite(times_s))
    time_s = times_s[finite]
    kept = np.arange(len(time_s)) if np.all(np.diff(time_s) > 0) else _longest_increasing(time_s.tolist())
    repeated = int(np.count_nonzero(np.isin(np.delete(time_s, kept), time_s[kept])))
    return finite[kept], RemovedRows(len(times_s) - len(finite), repeated, len(time_s) - len(kept) - repeated)


def _longest_increasing(times_s: Sequence[float]) -> Rows:
    """Return the rows of a longest strictly increasing subsequence, in O(n log n) steps.

    ends[k] is the least time at which an increasing subsequence of length k + 1 can end, at[k] the row of that time;
    before[row] is the row ahead of it in the longest subsequence that ends there.
    """
    ends: list[float] = []
    at: list[int] = []
    before: list[int] = []
    for row, time_s in enumerate(times_s):
        length = bisect_left(ends, time_s)
        before.append(at[length - 1] if length else -1)
        ends[length : length + 1], at[length : length + 1] = [time_s], [row]  # replaces, or appends at the end
    rows = [at[-1]]
    while before[rows[-1]] >= 0:
        rows.append(before[rows[-1]])
    return np.array(rows[::-1], np.int64)


def _carried(at_s: Array, stream: Stream, rows: Rows) -> dict[str, Values]:
    """Return the columns of a stream's rows at times (m,); a row that lacks part of a group counts as not sampled."""
    carried: dict[str, Values] = {}
    for names, how in stream.groups.items():
        values = np.column_stack([stream.columns[name][rows] for name in names])
        known = ~_is_missing(values).any(axis=1)
        times_s = stream.times_s[rows][known]
        gap_s = np.nan_to_num(stream.max_gap_intervals * own_interval_s(times_s), nan=np.inf)  # a single event: inf * 0
        found = covered(at_s, times_s, how, gap_s)
        nothing = np.array(np.nan if values.dtype.kind in NUMBERS else "")
        block = np.full((len(at_s), len(names)), nothing, np.result_type(values, nothing))
        if found.any():
            block[found] = interpolated(at_s[found], times_s, values[known], how)
        carried |= zip(names, block.T, strict=True)
    return carried


def _is_missing(values: Values) -> NDArray[np.bool_]:
    """Return where numbers are not finite, or words are empty."""
    return ~np.isfinite(values) if values.dtype.kind in NUMBERS else np.asarray(values == "")


def _same_sign(q: Array) -> Array:
    """Return quaternions (n, 4) with signs such that neighbours lie on the shorter arc; q and -q are one attitude."""
    turns = np.sign(np.sum(q[1:] * q[:-1], axis=1))
    return q * np.cumprod(np.r_[1.0, np.where(turns == 0, 1.0, turns)])[:, None]


def _spherical(at_s: Array, times_s: Array, q: Array) -> Array:
    """Return unit quaternions at a constant rate between neighbours, which lie on the shorter arc: (m, 4).

    q(u) = (sin((1 - u) w) q_i + sin(u w) q_i+1) / sin w,  w = 2 asin(|q_i+1 - q_i| / 2) <= pi / 2;
    sin(u w) / sin w = u sinc(u w) / sinc(w), so that w = 0 needs no case of its own.
    """
    if len(q) == 1:
        return np.repeat(q, len(at_s), axis=0)
    row = np.clip(np.searchsorted(times_s, at_s, "right") - 1, 0, len(q) - 2)
    u = np.clip((at_s - times_s[row]) / (times_s[row + 1] - times_s[row]), 0.0, 1.0)
    half_turns = 2 / np.pi * np.arcsin(np.minimum(np.linalg.norm(q[row + 1] - q[row], axis=1) / 2, 1.0))
    before, after = ((share * np.sinc(share * half_turns) / np.sinc(half_turns))[:, None] for share in (1 - u, u))
    return np.asarray(before * q[row] + after * q[row + 1])
