"""The columns of a file under a recording's names and in a recording's units; `checks.py` looks at the values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from recordings.body_frame import turned
from recordings.columns import RUN, group_of, is_truth, mag_names, numbers
from recordings.decode import NotNumbersError, is_empty, is_timestamp, numbers_of, seconds_of, start_of, words_of
from recordings.interpretation import Interpretation, without_unit
from recordings.names import guessed_maps, stated_maps
from recordings.readers import load
from recordings.readers.base import FileContents, Wanted
from recordings.reading import Reading
from recordings.recording import STATED, Origin
from recordings.sensor_rows import magnetometer_rows
from recordings.units import ColumnMap
from recordings.whereabouts import date_at, date_in, place_in
from scenarios.arrays import Array
from scenarios.errors import InputError, errors_relocated

NANOTESLA = "nT"
LARGEST = 1e30
"""No quantity is larger in any unit; loggers write the largest float for "no value", so larger values are infinite."""

NOTHING_STATED = Reading()
Source = tuple[pa.ChunkedArray, ColumnMap | None]
"""A column of a file, and the map that named it."""


@dataclass(frozen=True)
class RawColumns:
    """The columns of a file before any check: float64 (n,), NaN for an empty cell; words for `phase`.

    sources : name -> name in the file, for renamed columns. origin : how they were read, with the reader's notes.
    strict : whether every row counts, as in memory, where results stand beside the rows: none is skipped or moved.
    """

    path: Path
    named: dict[str, NDArray[Any]]
    sources: Mapping[str, str] = field(default_factory=dict)
    origin: Origin = STATED
    strict: bool = False


def read_columns(
    path: Path, reading: Reading = NOTHING_STATED, wanted: Wanted = lambda name: not is_truth(name)
) -> RawColumns:
    """Read a file of any format in `readers.FORMATS`; columns are mapped and converted.

    reading : what is stated of the file.
    wanted : which of the other columns to read; by default all but the truth.

    Time may be a timestamp and becomes seconds since the first. Text, and an optional column without any value, is left
    out. Raises InputError for a file that cannot be read, lacks a column of time or field, or has text in place of
    numbers.
    """
    sources = {entry.source for entry in reading.column_maps}
    contents = load(path, lambda name: name in sources or (bool(name) and wanted(name)), reading.stream)
    return raw_columns(path, contents, reading)


def sensors_in(path: Path, reading: Reading | None = None) -> tuple[int, ...]:
    """Return the numbers of an array's magnetometers in a file, ascending; empty for a single magnetometer.

    Raises InputError for a file that cannot be read.
    """
    own = Reading.for_file(path, reading=reading)
    parsed = own.column_maps
    names = load(path, lambda name: group_of(name) == "mag", own.stream).table.column_names
    renamed = {entry.source for entry in parsed}
    return numbers("mag", [*(name for name in names if name not in renamed), *(entry.target for entry in parsed)])


def raw_columns(path: Path, contents: FileContents, reading: Reading = NOTHING_STATED) -> RawColumns:
    """Return the columns of a file, mapped and converted, see `read_columns`; messages call the file `path`."""
    table, known = contents.table, contents.magnetometer != ""
    _check_unit(path, contents, reading)
    with errors_relocated(str(path), ""):
        table, skipped = magnetometer_rows(table, None if known else reading.stream)
        stated = stated_maps(table, reading)
        guessed = guessed_maps(table, stated)
    named = _named(path, table, (*stated, *guessed))
    _check_names(path, tuple(named), table.schema, in_plane=len(reading.mag) == 2 or _in_plane(guessed))
    decoded = {name: _decoded(path, name, *source) for name, source in named.items()}
    kept = {name: values for name, values in decoded.items() if values is not None}
    found = Interpretation(kept, (*stated, *guessed), guessed, reading, unit=contents.unit)
    found.settle()
    notes = (*contents.notes, *skipped, *found.line, *found.notes)
    if contents.frame:
        reading = replace(reading, frame=None)
    start_s = _start_s(named.get("time_s"), contents, found)
    return RawColumns(path, turned(found.named, reading), found.sources, _origin(contents, found, notes, start_s))


def _check_unit(path: Path, contents: FileContents, reading: Reading) -> None:
    """Raise InputError for another unit than nT, stated of a log whose reader gives nT."""
    known = contents.magnetometer != "" and contents.unit == NANOTESLA and not reading.mag
    if known and reading.unit not in (None, NANOTESLA):
        what = "does not apply: the reader of this format gives nT already"
        raise InputError(what, where=f"{path}: --unit {reading.unit}", do="leave it out")


def _start_s(time: Source | None, contents: FileContents, found: Interpretation) -> float | None:
    """Return seconds since 1970 at time_s = 0: by timestamps, by stamps since 1970, or as the reader tells."""
    if time is not None and is_timestamp(time[0]):
        return start_of(time[0])
    return contents.start_s if found.start_s is None else found.start_s


def _origin(contents: FileContents, found: Interpretation, notes: tuple[str, ...], start_s: float | None) -> Origin:
    """Return how a log was read: what is stated counts before what the log tells."""
    stated = found.reading
    return Origin(
        *(notes, found.unit, found.timed, found.axes, contents.frame or stated.frame or ""),
        magnetometer=contents.magnetometer,
        magnetometers=contents.magnetometers,
        place=stated.place or contents.place or place_in(found.named),
        date=stated.date or contents.date or date_at(start_s, found.named["time_s"]) or date_in(contents.table),
        start_s=start_s,
        applied=contents.applied.get(contents.magnetometer),
    )


def _in_plane(guessed: Sequence[ColumnMap]) -> bool:
    """Return whether x and y of a magnetometer were found, and no z."""
    x, y, z = mag_names()
    targets = {one.target for one in guessed}
    return {x, y} <= targets and z not in targets


def _named(path: Path, table: pa.Table, maps: Sequence[ColumnMap]) -> dict[str, Source]:
    """Return the columns under their new names, without mapped sources and without the number of the run."""
    for entry in maps:
        if entry.source not in table.column_names:
            what, do = f"there is no column {entry.source!r}", f"the file has {_listed(table.schema)}"
            raise InputError(what, where=f"{path}: --map {entry.target}={entry.source}", do=do)
    left_out = {RUN.name, *(entry.source for entry in maps)}
    kept: dict[str, Source] = {name: (table.column(name), None) for name in table.column_names if name not in left_out}
    return kept | {entry.target: (table.column(entry.source), entry) for entry in maps}


def _check_names(path: Path, names: Sequence[str], schema: pa.Schema, *, in_plane: bool) -> None:
    """Raise InputError unless there is a field, of a single magnetometer or of an array; in a plane without z."""
    sensors = numbers("mag", names)
    if sensors and any(name in names for name in mag_names()):
        what = "holds both mag_x_nT … and mag1_x_nT …: one magnetometer or an array?"
        raise InputError(what, where=str(path), do="keep one of the two, or rename the other")
    _check_numbers(path, sensors)
    field = [name for sensor in sensors or (None,) for name in mag_names(sensor)]
    missing = next((name for name in field[: 2 if in_plane else None] if name not in names), None)
    if missing is not None:
        example = missing.replace("mag_", "b").replace("_nT", ",unit=uT")
        what = f"there is no column {missing}; the file has {_listed(schema)}"
        raise InputError(what, where=str(path), do=f"name it with --map {missing}={example}, or all with --mag")


def _check_numbers(path: Path, sensors: Sequence[int]) -> None:
    """Raise InputError unless an array's sensors count from 1 without a gap, as results do."""
    missing = next((k for k, sensor in enumerate(sensors, start=1) if k != sensor), None)
    if missing is not None:
        listed, name = ", ".join(map(str, sensors)), mag_names(missing)[0]
        what = f"holds the sensors {listed} of an array, without {missing}: results count them from 1"
        do = f"number them 1 to {len(sensors)}, as by --map {name}={mag_names(sensors[missing - 1])[0]}"
        raise InputError(what, where=str(path), do=do)


def _listed(schema: pa.Schema) -> str:
    fields = [f"{f.name} ({f.type})" if pa.types.is_nested(f.type) else f.name for f in schema if f.name]
    return ", ".join(fields[:20]) + (f" and {len(fields) - 20} more" if len(fields) > 20 else "") or "no columns"


def _decoded(path: Path, name: str, column: pa.ChunkedArray, entry: ColumnMap | None) -> NDArray[Any] | None:
    """Return a column as words, or as numbers in its unit; None for text, and for an optional column without values."""
    group = group_of(name)
    if is_empty(column) and group not in ("time", "mag", "phase"):
        return None
    try:
        values = _cells(column, group)
    except NotNumbersError as error:
        if group == "channel" and not error.mixed:
            return None
        raise InputError(error.what, where=f"{path}: {name}", do=error.do) from None
    except (pa.ArrowException, ValueError, OverflowError) as error:
        reason = " ".join(str(error).split())[:160]
        raise InputError(f"cannot be read: {reason}", where=f"{path}: {name}", do="store it as numbers") from None
    return values if group == "phase" else _bounded(values if entry is None else without_unit(entry).convert(values))


def _cells(column: pa.ChunkedArray, group: str) -> NDArray[Any]:
    if group == "phase":
        return words_of(column)
    if group == "time" and is_timestamp(column):
        return seconds_of(column)
    return numbers_of(column)


def _bounded(values: Array) -> Array:
    """Return the values with infinity for whatever exceeds LARGEST."""
    if len(values) and max(np.fmax.reduce(values), -np.fmin.reduce(values)) <= LARGEST:
        return values
    large = np.abs(values) > LARGEST
    return np.where(large, np.copysign(np.inf, values), values) if large.any() else values
