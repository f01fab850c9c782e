"""A base station's record of the day's change, taken off a recording before it is calibrated.

m = S (h + dh(t)) + b:  without attitude  m' = b + (m - b) F / (F + dF(t));  with it  m' = m - S R_wb^T dh(t)

dF, dh : the station's strength and vector minus their means over the recording's time
"""

from __future__ import annotations

import datetime
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from calib import Calibration, Reference, get
from calib.numerics.rates import world_to_body
from recordings import Recording, read_recording
from recordings.channels import SCALAR
from recordings.columns import mag_names
from recordings.decode import NotNumbersError, is_timestamp, numbers_of, seconds_of, start_of
from recordings.readers import load
from recordings.readers.iaga import NO_BODY_FRAME
from scenarios.arrays import Array
from scenarios.errors import InputError
from validation.text import figure

ROUNDS = 3
"""Fits by which offset and matrix are found that the change is taken off about; the change is a small part of F."""
MOST_GAP_S = 600.0
"""A gap of the station's record, beyond which the change inside is not known."""
LEAST_RECORDS = 2
"""Records of a strength between which there is a change."""
OPTION, START = "--base", "--base-start"


@dataclass(frozen=True, eq=False)
class BaseStation:
    """A station's strength (n,), nT, at times (n,), s since 1970, and the vector (n, 3) east, north, up where known."""

    where: str
    times_s: Array
    strength_nT: Array
    field_enu_nT: Array | None = None

    @classmethod
    def read(cls, path: Path) -> BaseStation:
        """Read an observatory's file, or a log with the time of day, and `scalar_nT` or a field.

        The vector is known of an observatory, whose axes are north, east, down. Raises InputError for a file that
        cannot be read, and for one without the time of day.
        """
        table = load(path, lambda name: name in ("time_s", SCALAR, *mag_names())).table
        if SCALAR in table.column_names and mag_names()[0] not in table.column_names:
            return cls(str(path), *_scalar_record(path, table))
        record = read_recording(path)
        if record.origin.start_s is None:
            raise _undated(path)
        scalar = record.channels.get(SCALAR)
        observatory = NO_BODY_FRAME in record.origin.notes
        strength_nT = np.linalg.norm(record.mag_nT, axis=1) if observatory or scalar is None else scalar
        enu = record.mag_nT[:, [1, 0, 2]] * [1.0, 1.0, -1.0] if observatory else None
        return cls(str(path), record.time_s + record.origin.start_s, np.asarray(strength_nT), enu)

    def change(self, times_s: Array) -> tuple[Array, Array | None]:
        """Return dF (n,) and dh (n, 3) at times, minus their means; InputError where the record does not cover them."""
        self._check_covered(times_s)
        strength = np.interp(times_s, self.times_s, self.strength_nT)
        if self.field_enu_nT is None:
            return strength - strength.mean(), None
        vector = np.column_stack([np.interp(times_s, self.times_s, part) for part in self.field_enu_nT.T])
        return strength - strength.mean(), vector - vector.mean(axis=0)

    def _check_covered(self, times_s: Array) -> None:
        first, last = float(times_s.min()), float(times_s.max())
        inside = self.times_s[(self.times_s > first) & (self.times_s < last)]
        before, after = self.times_s[self.times_s <= first], self.times_s[self.times_s >= last]
        if not len(before) or not len(after):
            what = f"covers {_utc(self.times_s[0])} to {_utc(self.times_s[-1])}, the log {_utc(first)} to {_utc(last)}"
            raise InputError(what, where=f"{OPTION} {self.where}", do="give the record of the log's day (times in UTC)")
        gap_s = float(np.diff(np.concatenate((before[-1:], inside, after[:1]))).max(initial=0.0))
        if gap_s > MOST_GAP_S:
            what = f"has a gap of {gap_s:.0f} s in the log's time, more than {MOST_GAP_S:g} s"
            raise InputError(what, where=f"{OPTION} {self.where}", do="give another station's record")


def _scalar_record(path: Path, table: pa.Table) -> tuple[Array, Array]:
    """Return times, s since 1970, and the strength of a table of `time_s` (dates) and `scalar_nT`."""
    if "time_s" not in table.column_names or not is_timestamp(table.column("time_s")):
        raise _undated(path)
    try:
        strength_nT = numbers_of(table.column(SCALAR))
    except NotNumbersError as error:
        raise InputError(error.what, where=f"{path}: {SCALAR}", do=error.do) from None
    times_s = start_of(table.column("time_s")) + seconds_of(table.column("time_s"))
    known = np.isfinite(strength_nT) & np.isfinite(times_s)
    if np.count_nonzero(known) < LEAST_RECORDS or (np.diff(times_s[known]) <= 0).any():
        what = "has no two records of the strength in order of time"
        raise InputError(what, where=f"{OPTION} {path}", do="give another record")
    return times_s[known], strength_nT[known]


def _undated(path: Path) -> InputError:
    do = "give an IAGA-2002 file, or a log whose times are dates"
    return InputError("tells no date and time of day", where=f"{OPTION} {path}", do=do)


@dataclass(frozen=True, eq=False)
class WithoutChange:
    """A recording without the day's change, and the change of the strength, nT, from least to greatest."""

    recording: Recording
    station: str
    low_nT: float
    high_nT: float
    by_vector: bool

    @property
    def line(self) -> str:
        """What was done, in one line."""
        how = "as a vector, by the attitude" if self.by_vector else "along the measured field"
        size = f"{figure(self.low_nT)} to {figure(self.high_nT)} nT"
        return f"base station {self.station}: the day's change of the strength, {size}, is taken off {how}"

    def summary(self) -> dict[str, Any]:
        """Return the JSON of `--json`."""
        return {
            "station": self.station,
            "low_nT": self.low_nT,
            "high_nT": self.high_nT,
            "by": "vector" if self.by_vector else "strength",
        }


def day_start_s(recording: Recording, stated: str | None) -> float:
    """Return seconds since 1970 (UTC) at time_s = 0: as stated, else as the log tells.

    Raises InputError for a text that is no date and time, and where neither is known.
    """
    if stated is not None:
        try:
            moment = datetime.datetime.fromisoformat(stated)
        except ValueError:
            do = "give UTC, such as 2024-05-01T12:30:00"
            raise InputError(f"{stated!r} is no date and time", where=START, do=do) from None
        zoned = moment if moment.tzinfo else moment.replace(tzinfo=datetime.UTC)
        return zoned.timestamp()
    if recording.origin.start_s is None:
        do = f"give UTC at the log's time 0: {START} 2024-05-01T12:30:00"
        raise InputError("the log tells no time of day", where=OPTION, do=do)
    return recording.origin.start_s


def without_change(
    recording: Recording, reference: Reference, station: BaseStation, start: str | None = None
) -> WithoutChange:
    """Return the recording with the day's change taken off.

    start : UTC at time_s = 0, where the log tells none. The vector's change is taken off where attitude and the
    station's vector are known; the strength's change else. Raises InputError for a log without times, without the time
    of day, and outside the station's record.
    """
    if not recording.origin.timed:
        raise InputError("the log has no times", where=OPTION, do="log them, or name their column with --map")
    strength_nT, vector_nT = station.change(recording.time_s + day_start_s(recording, start))
    by_vector = vector_nT is not None and recording.att_q is not None
    if by_vector:
        assert vector_nT is not None
        assert recording.att_q is not None
        change = world_to_body(recording.att_q, vector_nT)
    else:
        change = strength_nT
    found = replace(recording, mag_nT=_corrected(recording, reference, change))
    if recording.array_mag_nT is not None:
        sensors = [recording.sensor(k) for k in range(len(recording.array_mag_nT))]
        found = replace(found, array_mag_nT=np.stack([_corrected(one, reference, change) for one in sensors]))
    return WithoutChange(found, station.where, float(strength_nT.min()), float(strength_nT.max()), by_vector)


def _corrected(recording: Recording, reference: Reference, change: Array) -> Array:
    """Return the measurements (n, 3) without a change of the strength (n,) or of the field in the body (n, 3).

    Offset and matrix are those of an ellipsoid, in rounds; a motion that determines none takes the sphere's, or the
    middle of the measurements and the identity.
    """
    mag_nT = recording.mag_nT
    for _ in range(ROUNDS):
        fit = _ellipsoid(replace(recording, mag_nT=mag_nT, array_mag_nT=None), reference)
        if change.ndim == 2:
            mag_nT = recording.mag_nT - change @ np.linalg.inv(fit.matrix).T
        else:
            factor = reference.strength_nT / (reference.strength_nT + change)
            mag_nT = fit.offset_nT + (recording.mag_nT - fit.offset_nT) * factor[:, None]
    return np.asarray(mag_nT)


def _ellipsoid(recording: Recording, reference: Reference) -> Calibration:
    """Return offset and matrix of an ellipsoid, a sphere, or else the middle of the measurements and the identity."""
    strength = Reference(reference.strength_nT)
    for name in ("ellipsoid", "sphere"):
        found = get(name).fit(recording, strength)
        if found.status.kind == "ok":
            return found
    middle = (recording.mag_nT.min(axis=0) + recording.mag_nT.max(axis=0)) / 2
    return replace(found, offset_nT=middle, matrix=np.eye(3))


def _utc(time_s: float) -> str:
    return datetime.datetime.fromtimestamp(float(time_s), datetime.UTC).strftime("%Y-%m-%d %H:%M:%S")
