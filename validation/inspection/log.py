"""Columns of a file under standard names and in standard units, with all faults kept."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recordings import Recording
from recordings.assemble import recording_of
from recordings.checks import MIN_INTERVAL_S, check_columns, check_field
from recordings.columns import ACCEL, ATTITUDE, GYRO, mag_names, numbers
from recordings.importer import RawColumns, read_columns
from recordings.manifest import file_of
from recordings.mending import mended
from recordings.reading import Reading
from recordings.recording import STATED, Origin
from scenarios.arrays import Array
from scenarios.errors import InputError

LATEST_S = 1e19
"""Largest time stamp: nanoseconds since 1970, read as seconds, are a fifth."""


@dataclass(frozen=True)
class RawLog:
    """Recording before any check.

    columns : name -> (n,), numbers in the units of the names, NaN for empty cells.
    sources : name -> name in the file, for renamed columns.
    refusal : reason why `magbench calibrate` refuses the file, "" for an accepted file.
    recording : as `magbench calibrate` reads the file, None for a refused file.
    frame : the body frame that was stated, "flu" or "frd"; the columns are in FLU.
    faulty : the columns before rows and times were mended, where they were; their faults are findings.
    """

    path: Path
    columns: dict[str, Array]
    sources: dict[str, str]
    refusal: str
    recording: Recording | None = None
    frame: str = ""
    faulty: dict[str, Array] | None = None
    origin: Origin = STATED

    def __len__(self) -> int:
        return len(self.columns["time_s"])

    @property
    def as_found(self) -> dict[str, Array]:
        """Return the columns with the faults of rows and times."""
        return self.columns if self.faulty is None else self.faulty

    @property
    def sensors(self) -> tuple[int | None, ...]:
        """Return the numbers of an array's sensors, or (None,) for a single magnetometer."""
        return numbers("mag", tuple(self.columns)) or (None,)

    def vector(self, names: Sequence[str]) -> Array | None:
        """Return columns side by side (n, k), None unless all are present."""
        if not all(name in self.columns for name in names):
            return None
        return np.column_stack([self.columns[name] for name in names])


@dataclass(frozen=True)
class Series:
    """Rows of a magnetometer with finite field and increasing time; None for quantities not measured.

    rows : (n,) indices of the rows in the file. Vectors other than the field may have NaN.
    """

    rows: NDArray[np.intp]
    time_s: Array
    mag_nT: Array
    gyro_rad_s: Array | None
    accel_m_s2: Array | None
    att_q: Array | None

    def __len__(self) -> int:
        return len(self.time_s)

    def taken(self, keep: NDArray[np.bool_], mag_nT: Array) -> Series:
        """Return the series of the m rows to keep (n,), with the field (m, 3) in them."""
        others = {name: getattr(self, name) for name in ("gyro_rad_s", "accel_m_s2", "att_q")}
        kept = {name: None if values is None else values[keep] for name, values in others.items()}
        return Series(self.rows[keep], self.time_s[keep], mag_nT, **kept)

    def scaled(self, factor: float) -> Series:
        """Return the series with the field multiplied by `factor`."""
        return replace(self, mag_nT=factor * self.mag_nT)


def read_log(path: Path, *, maps: Sequence[str] = (), reading: Reading | None = None, run: int = 0) -> RawLog:
    """Read a run, a dataset directory (run number `run`) or a measured log read as stated.

    Raises InputError for a file that cannot be read, without numeric columns of time and field.
    """
    file = file_of(path, run)
    return log_of(read_columns(file, Reading.for_file(file, maps, reading)))


def log_of(raw: RawColumns) -> RawLog:
    """Return the log of columns that have been read, mended as the other commands do."""
    whole = mended(raw)
    faulty = None if whole is raw else _numbers(raw)
    return RawLog(
        raw.path, _numbers(whole), dict(raw.sources), *_accepted(whole), whole.origin.frame, faulty, whole.origin
    )


def _numbers(raw: RawColumns) -> dict[str, Array]:
    return {name: np.asarray(values, np.float64) for name, values in raw.named.items() if name != "phase"}


def _accepted(whole: RawColumns) -> tuple[str, Recording | None]:
    """Return why the columns are refused, "" with their recording if they are not."""
    try:
        return "", recording_of(check_field(whole, check_columns(whole)), whole.origin)
    except InputError as error:
        return str(error).removeprefix(f"{whole.path}: "), None


def series_of(log: RawLog, sensor: int | None) -> Series:
    """Return the sound rows of a magnetometer in order of time: finite, no repeated or absurd time stamps."""
    field = log.vector(mag_names(sensor))
    assert field is not None
    time_s = log.columns["time_s"]
    rows = np.flatnonzero((np.abs(time_s) < LATEST_S) & np.isfinite(field).all(axis=1))
    rows = rows[np.unique(time_s[rows], return_index=True)[1]]
    rows = rows[np.diff(time_s[rows], prepend=-np.inf) >= MIN_INTERVAL_S]
    gyro, accel, attitude = (_measured(log.vector(names), rows) for names in (GYRO, ACCEL, ATTITUDE))
    return Series(rows, time_s[rows], field[rows], gyro, accel, attitude)


def _measured(values: Array | None, rows: NDArray[np.integer]) -> Array | None:
    """Return an instrument's vectors with NaN for infinities; None without any complete vector."""
    if values is None:
        return None
    known = np.where(np.isinf(values[rows]), np.nan, values[rows])
    return known if np.isfinite(known).all(axis=1).any() else None
