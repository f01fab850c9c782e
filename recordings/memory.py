"""Recordings from arrays and data frames in memory, checked as files are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np
import pyarrow as pa
from numpy.typing import ArrayLike

from recordings.columns import mag_names
from recordings.importer import RawColumns, raw_columns
from recordings.reader import checked_recording
from recordings.readers import FileContents
from recordings.reading import Reading, report
from recordings.recording import Recording
from scenarios.arrays import Array
from scenarios.errors import InputError

WANTED = "pass an array (n, 3) in nT, a data frame or dict with columns time_s and mag_x_nT …, a path, or a Recording"
ARRAY, FRAME = Path("array"), Path("data frame")
"""The names of data in memory, in messages that would name a file."""
CONVERSION = (pa.ArrowException, ValueError, TypeError, OverflowError)
"""The exceptions of Arrow for values of no Arrow type."""


@runtime_checkable
class Frame(Protocol):
    """A data frame of pandas, polars, pyarrow and the like, which hands over its columns in Arrow's form."""

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """Return a stream of the columns."""


def raw_columns_of(data: object, *, time_s: ArrayLike | None = None, reading: Reading | None = None) -> RawColumns:
    """Return the columns of an array (n, 3) in nT, of a data frame, or of a dict of columns, before any check.

    time_s : (n,) the times of an array's samples; by default the samples are a second apart.
    reading : as for files, see `importer.read_columns`.
    Raises InputError for another type, and for an array of another shape.
    """
    if time_s is not None and isinstance(data, Frame | Mapping):
        raise InputError("is given beside columns", where="time_s", do="name the time_s column, or pass an array")
    place, columns = FRAME, data
    if isinstance(data, Mapping):
        columns = {str(name): _column(str(name), values) for name, values in data.items()}
    elif not isinstance(data, Frame):
        place, columns = ARRAY, _array_columns(data, time_s)
    try:
        table = pa.table(columns)
    except CONVERSION as error:
        raise _unreadable(error, str(FRAME)) from None
    return replace(raw_columns(place, FileContents({"": table}), reading or Reading()), strict=True)


def recording_in_memory(data: object, *, time_s: ArrayLike | None = None, reading: Reading | None = None) -> Recording:
    """Return the recording in memory, checked and filled as a measured log is; arguments as `raw_columns_of`.

    Raises InputError for data that are not fit for use.
    """
    raw = raw_columns_of(data, time_s=time_s, reading=reading)
    recording = checked_recording(raw)
    report(*recording.origin.notes)
    return recording


def _array_columns(data: object, time_s: ArrayLike | None) -> dict[str, Array]:
    """Return time and field of an array (n, 3) as columns."""
    mag_nT = _field(data)
    time = np.arange(len(mag_nT), dtype=np.float64) if time_s is None else _times(time_s, len(mag_nT))
    return {"time_s": time, **dict(zip(mag_names(), mag_nT.T, strict=True))}


def _unreadable(error: Exception, where: str) -> InputError:
    return InputError(f"cannot be read: {' '.join(str(error).split())[:160]}", where=where, do=WANTED)


def _column(name: str, values: object) -> pa.Array | np.ndarray[tuple[int], np.dtype[np.generic]]:
    try:
        column = np.asarray(_without_mask(values))
    except ValueError:
        column = np.empty((0, 0))
    if column.ndim != 1:
        raise InputError("is not a column of values", where=f"{FRAME}: {name}", do="give (n,) values, one a sample")
    if column.dtype != object:
        return column
    try:
        return pa.array(values)
    except CONVERSION as error:
        raise _unreadable(error, f"{FRAME}: {name}") from None


def _without_mask(values: object) -> object:
    """Return masked numbers with NaN in place of masked cells, and any other values unchanged."""
    masked = isinstance(values, np.ma.MaskedArray) and values.dtype.kind in "fiu"
    return np.ma.filled(np.ma.asarray(values, np.float64), np.nan) if masked else values


def _field(data: object) -> Array:
    """Return data as an array (n, 3) of numbers, NaN in place of masked cells; InputError for other data."""
    kind = type(data).__name__
    if data is None or isinstance(data, str | bytes | int | float | complex):
        raise InputError(f"is of type {kind}, not a recording", where="data", do=WANTED)
    values = _array(data, str(ARRAY), WANTED)
    if values.dtype.kind not in "fiu":
        raise InputError(f"{kind} holds {values.dtype}, not numbers", where="data", do=WANTED)
    if values.ndim == 2 and values.shape[0] == 3 != values.shape[1]:
        raise InputError(f"has shape {values.shape}", where=str(ARRAY), do="rows are samples: pass its transpose, .T")
    if values.ndim != 2 or values.shape[1] != 3:
        raise InputError(f"has shape {values.shape}, not (n, 3)", where=str(ARRAY), do=WANTED)
    return np.asarray(np.ma.filled(np.ma.asarray(data, np.float64), np.nan))


def _times(time_s: ArrayLike, samples: int) -> Array:
    do = "give the time of every sample, in seconds"
    values = _array(time_s, "time_s", do)
    if values.dtype.kind not in "fiu" or values.shape != (samples,):
        what = f"has shape {values.shape} and type {values.dtype}, not ({samples},) numbers"
        raise InputError(what, where="time_s", do=do)
    return values.astype(np.float64)


def _array(values: object, where: str, do: str) -> np.ndarray[tuple[int, ...], np.dtype[np.generic]]:
    """Return values as an array; InputError for nested sequences of unequal length."""
    try:
        return np.asarray(values)
    except ValueError:
        raise InputError("its rows differ in length", where=where, do=do) from None
