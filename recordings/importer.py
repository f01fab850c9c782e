"""The columns of a file under the recording's names and in its units; `checks.py` looks at their values."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from recordings.columns import RUN, group_of, is_truth, mag_names, numbers
from recordings.decode import NotNumbersError, is_empty, is_timestamp, numbers_of, seconds_of, words_of
from recordings.tabular import load_table
from recordings.units import ColumnMap, parse_maps
from scenarios.arrays import Array
from scenarios.errors import InputError

LARGEST = 1e30
"""No quantity is larger in any unit; loggers write the largest float for "no value", so beyond it is infinite."""


@dataclass(frozen=True)
class RawColumns:
    """A file's columns before any check: float64 (n,) with NaN where a cell is empty, words where `phase` has them."""

    path: Path
    named: dict[str, NDArray[Any]]


def read_columns(
    path: Path, maps: Sequence[str] = (), wanted: Callable[[str], bool] = lambda name: not is_truth(name)
) -> RawColumns:
    """Read a Parquet or CSV file of any origin, mapped and converted.

    maps : `TARGET=SOURCE[,unit=U][,scale=F]`; the source is renamed, converted to the target's unit, multiplied by F.
    wanted : which of the other columns to read; none of the truth, unless the caller says so.

    Time may be a timestamp and is then seconds since the first. Text, and an optional column without any value, is left
    out. Raises InputError for a file that cannot be read, without columns of time and field, or with text in their
    place.
    """
    sources = {one.source for one in parse_maps(maps)}
    return columns_of(path, load_table(path, lambda name: name in sources or (bool(name) and wanted(name))), maps)


def sensors_in(path: Path, maps: Sequence[str] = ()) -> tuple[int, ...]:
    """The numbers of an array's magnetometers in a file, ascending; none where there is but one magnetometer.

    Raises InputError for a file that cannot be read.
    """
    named = parse_maps(maps)
    table = load_table(path, lambda name: group_of(name) == "mag")
    renamed = {one.source for one in named}
    return numbers("mag", [*(name for name in table.column_names if name not in renamed), *(m.target for m in named)])


def columns_of(path: Path, table: pa.Table, maps: Sequence[str] = ()) -> RawColumns:
    """The columns of a table, mapped and converted, see `read_columns`; `path` is what messages call it."""
    named = _named(path, table, parse_maps(maps))
    _check_names(path, tuple(named), table.schema)
    decoded = {name: _decoded(path, name, *source) for name, source in named.items()}
    return RawColumns(path, {name: values for name, values in decoded.items() if values is not None})


Source = tuple[pa.ChunkedArray, ColumnMap | None]


def _named(path: Path, table: pa.Table, maps: Sequence[ColumnMap]) -> dict[str, Source]:
    """The columns under the names that they are to have; what a map replaces is gone, and the number of a run."""
    for one in maps:
        if one.source not in table.column_names:
            where = f"{path}: --map {one.target}={one.source}"
            raise InputError(
                f"there is no column {one.source!r}", where=where, do=f"the file has {_listed(table.schema)}"
            )
    used = {one.source for one in maps}
    left_out = used | {RUN.name}
    kept: dict[str, Source] = {name: (table.column(name), None) for name in table.column_names if name not in left_out}
    return kept | {one.target: (table.column(one.source), one) for one in maps}


def _check_names(path: Path, names: Sequence[str], schema: pa.Schema) -> None:
    sensors = numbers("mag", names)
    if sensors and any(name in names for name in mag_names()):
        what = "holds both mag_x_nT … and mag1_x_nT …: one magnetometer or an array?"
        raise InputError(what, where=str(path), do="keep one of the two, or rename the other")
    _check_numbers(path, sensors)
    field = [name for sensor in sensors or (None,) for name in mag_names(sensor)]
    missing = next((name for name in ("time_s", *field) if name not in names), None)
    if missing is not None:
        example = "t,unit=ms" if missing == "time_s" else missing.replace("mag_", "b").replace("_nT", ",unit=uT")
        what = f"there is no column {missing}; the file has {_listed(schema)}"
        raise InputError(what, where=str(path), do=f"name it with --map {missing}={example}")


def _check_numbers(path: Path, sensors: Sequence[int]) -> None:
    """An array's sensors count from 1 without a gap, as results do; InputError otherwise."""
    missing = next((k for k, sensor in enumerate(sensors, start=1) if k != sensor), None)
    if missing is not None:
        listed, name = ", ".join(map(str, sensors)), mag_names(missing)[0]
        what = f"holds the sensors {listed} of an array, without {missing}: results count them from 1"
        do = f"number them 1 to {len(sensors)}, as by --map {name}={mag_names(sensors[missing - 1])[0]}"
        raise InputError(what, where=str(path), do=do)


def _listed(schema: pa.Schema) -> str:
    fields = [f"{f.name} ({f.type})" if pa.types.is_nested(f.type) else f.name for f in schema if f.name]
    return ", ".join(fields[:20]) + (f" and {len(fields) - 20} more" if len(fields) > 20 else "") or "no columns"


def _decoded(path: Path, name: str, column: pa.ChunkedArray, by: ColumnMap | None) -> NDArray[Any] | None:
    """A column as words, or as numbers in its unit; None for an optional one without values, and for text."""
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
    return values if group == "phase" else _bounded(values if by is None else by.convert(values))


def _cells(column: pa.ChunkedArray, group: str) -> NDArray[Any]:
    if group == "phase":
        return words_of(column)
    if group == "time" and is_timestamp(column):
        return seconds_of(column)
    return numbers_of(column)


def _bounded(values: Array) -> Array:
    large = np.abs(values) > LARGEST
    return np.where(large, np.copysign(np.inf, values), values) if large.any() else values
