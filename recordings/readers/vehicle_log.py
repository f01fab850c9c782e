"""A vehicle's log: several magnetometers and streams of other rates, as the columns of one magnetometer."""

from __future__ import annotations

import datetime
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from recordings.applied import AppliedCalibration
from recordings.columns import ACCEL, ATTITUDE, GYRO, POSITION, SIGNAL, group_of
from recordings.readers.base import FileContents, Wanted
from recordings.streams import NUMBERS, Stream, merge
from scenarios.errors import InputError

MOST_MISSING = 0.2
"""Share of the magnetometer's times without a value above which a quantity is left out, in place of the rows."""
LIMITS = {"position": 0.05}
"""Other such shares: no calibrator needs a position, and the first fix of satellites comes late."""
SINCE_1970_S = 1e8
"""Times beyond this count from 1970, and become seconds since the first sample."""
VECTORS = {"gyro": GYRO, "accelerometer": ACCEL, "attitude": ATTITUDE, "position": POSITION}
Columns = dict[str, NDArray[Any]]


@dataclass(frozen=True, eq=False)
class VehicleLog:
    """What a reader found in a vehicle's log, under a recording's names, in its units and frames (FLU, ENU).

    Parameters
    ----------
    magnetometers : name -> the stream of `mag_x_nT`, `mag_y_nT`, `mag_z_nT` and what else the sensor gives with each
        sample, the main magnetometer first; calibration undone, in nT, or in counts where `unit` says so.
    streams : name -> any other stream: `gyro_x_rad_s` ..., `att_qw` ... (SLERP), `current_1_A`, `phase` (HELD), and
        channels under the log's own names. No two streams have a column of one name.
    notes, frame, unit, place, date, start_s, applied : see `FileContents`; start_s at the streams' time 0.
    """

    magnetometers: Mapping[str, Stream]
    streams: Mapping[str, Stream] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    frame: str = ""
    unit: str = "nT"
    place: tuple[float, ...] | None = None
    date: datetime.date | None = None
    start_s: float | None = None
    applied: Mapping[str, AppliedCalibration] = field(default_factory=dict)

    def contents(self, path: Path, wanted: Wanted, stream: str | None) -> FileContents:
        """Return the columns at the times of one magnetometer, by default the main one.

        Rows without a gyro, accelerometer, attitude, position, temperature or current are left out; a quantity that
        lacks more than MOST_MISSING of the rows (position: LIMITS) is left out instead, as are channels that never
        change.
        Raises InputError for a magnetometer that the log does not hold, and for a log without a sample.
        """
        name, other = self._chosen(path, stream)
        used = {key: _wanted(one, wanted) for key, one in self.streams.items()}
        merged = merge(self.magnetometers[name], {key: one for key, one in used.items() if one.columns})
        columns, left_out = _complete(merged.columns)
        if not len(columns["time_s"]):
            raise InputError(f"holds no sample of the magnetometer {name}", where=str(path), do="give another log")
        start_s = self.start_s
        if columns["time_s"][0] > SINCE_1970_S:
            start_s = float(columns["time_s"][0])
            columns["time_s"] = columns["time_s"] - start_s
        removed = [f"{key}: {rows.total} rows out of order of time left out" for key, rows in merged.removed.items()]
        return FileContents(
            {name: pa.table(columns)},
            (*other, *self.notes, *removed, *left_out),
            magnetometers=tuple(self.magnetometers),
            frame=self.frame,
            unit=self.unit,
            place=self.place,
            date=self.date,
            start_s=start_s,
            applied={key: one for key, one in self.applied.items() if key == name},
        )

    def _chosen(self, path: Path, stream: str | None) -> tuple[str, tuple[str, ...]]:
        """Return the name of the magnetometer that is read, and a note where there are others."""
        names = list(self.magnetometers)
        if not names:
            raise InputError("holds no magnetometer", where=str(path), do="log it, or give another log")
        found = names[0] if stream is None else next((one for one in names if one.lower() == stream.lower()), None)
        if found is None:
            what = f"there is no magnetometer {stream!r}"
            raise InputError(what, where=f"{path}: --stream", do=f"choose among {', '.join(names)}")
        others = ", ".join(one for one in names if one != found)
        note = f"magnetometer {found} of {len(names)} is read (--stream reads another: {others})"
        return found, (note,) if others else ()


def _wanted(stream: Stream, wanted: Wanted) -> Stream:
    """Return the stream with its wanted columns; a quaternion stays whole."""
    groups = {names: how for names, how in stream.groups.items() if any(map(wanted, names))}
    names = [name for group in groups for name in group]
    columns = {name: stream.columns[name] for name in names}
    how = {name: stream.interpolation[name] for name in names if name in stream.interpolation}
    return Stream(stream.times_s, columns, how, stream.max_gap_intervals)


def _complete(columns: Columns) -> tuple[Columns, list[str]]:
    """Return the columns without gaps in what a calibrator may use, and a note for each kind of loss."""
    total = len(columns["time_s"])
    there = {what: _known(columns, names) for what, names in _quantities(columns).items()}
    rare = [what for what, known in there.items() if known.mean() < 1 - LIMITS.get(what, MOST_MISSING)]
    gone = {name for what in rare for name in _quantities(columns)[what]}
    notes = [f"left out, with a value at {there[what].mean():.0%} of the samples alone: {what}" for what in rare]
    used = {what: known for what, known in there.items() if what not in rare and not known.all()}
    kept = np.logical_and.reduce([np.ones(total, np.bool_), *used.values()])
    if used:
        notes.append(f"{total - np.count_nonzero(kept)} of {total} samples left out, without {_listed(list(used))}")
    whole = {name: values[kept] for name, values in columns.items() if name not in gone}
    telling, silent = _telling(whole)
    return telling, [*notes, *silent]


def _known(columns: Columns, names: Sequence[str]) -> NDArray[np.bool_]:
    """Return the rows (n,) in which all components have a value."""
    return np.asarray(np.logical_and.reduce([np.isfinite(columns[name]) for name in names]))


def _telling(columns: Columns) -> tuple[Columns, list[str]]:
    """Return the columns without channels that say nothing, and a note that lists these."""
    gone = [name for name, values in columns.items() if group_of(name) == "channel" and _says_nothing(values)]
    note = f"{len(gone)} channels left out that never change or are rarely there: {_listed(gone)}"
    return {name: values for name, values in columns.items() if name not in gone}, [note] if gone else []


def _quantities(columns: Columns) -> dict[str, tuple[str, ...]]:
    """Return the quantities whose gaps count, with their columns; an incomplete vector has no place."""
    vectors = {what: tuple(n for n in names if n in columns) for what, names in VECTORS.items()}
    single = {name: (name,) for name in columns if group_of(name) in ("temperature", "current")}
    return {what: names for what, names in (vectors | single).items() if names}


def _says_nothing(values: NDArray[Any]) -> bool:
    """Return whether a channel is constant, or has no value in more than MOST_MISSING of the rows."""
    if values.dtype.kind not in NUMBERS:
        return True
    finite = np.isfinite(values)
    return bool(finite.mean() < 1 - MOST_MISSING or np.ptp(values[finite]) == 0)


def _listed(names: Sequence[str], most: int = 4) -> str:
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def vector_columns(group: str, values: NDArray[np.float64]) -> Columns:
    """Return a vector (n, k) as the columns of a signal: "mag", "gyro", "accel", "attitude" (w x y z), "position"."""
    return dict(zip(SIGNAL[group].names(), values.T, strict=True))
