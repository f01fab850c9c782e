"""Measured logs, Parquet or CSV, as recordings: mapped, converted and checked once, where they enter."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from scenarios.errors import InputError
from sim.dataset.assemble import recording_of
from sim.dataset.checks import check_complete, check_length, check_mag, check_time, fill_gaps
from sim.dataset.columns import ACCEL, ATTITUDE, GYRO, POSITION, group_of, is_truth, mag_names, numbers
from sim.dataset.recording import Array, Recording
from sim.dataset.tabular import load_table
from sim.dataset.units import ColumnMap, parse_maps


def read_measured(path: Path, maps: Sequence[str] = ()) -> Recording:
    """Read a measured log with the recording's columns; all but time_s and mag_* are optional.

    maps : `TARGET=SOURCE[,unit=U][,scale=F]`; the source is renamed, converted to the target's unit, multiplied by F.

    Any other numeric column is a channel, other text is left out. Truth columns are never read. Time may be a timestamp
    and is then seconds since the first. A column logged at a lower rate than the field, that is with empty cells or NaN
    between its values, is interpolated linearly in time (an attitude along the shorter arc) and held at the ends.
    In columns that a calibrator uses a gap may last five of the column's own intervals; beyond that it is an outage and
    refused. A column without any value counts as not measured. Rows are counted from 1, without the header.

    Raises InputError with file, column and row for everything that is not fit for use.
    """
    chosen = parse_maps(maps)
    table = _mapped(path, load_table(path), chosen)
    _check_names(path, table)
    check_length(path, table.num_rows)
    named = _numeric(path, table, {one.target: one for one in chosen})
    check_time(path, named["time_s"])
    check_mag(path, named)
    for names in (GYRO, ACCEL, ATTITUDE, POSITION):
        check_complete(path, named, names, optional=names == POSITION)
    return recording_of(fill_gaps(path, named))


def _mapped(path: Path, table: pa.Table, maps: Sequence[ColumnMap]) -> pa.Table:
    """Only what may enter a recording, under its new name: no truth, and no column that a map replaces."""
    sources = {name: table.column(name) for name in table.column_names}
    for one in maps:
        if one.source not in sources:
            where = f"{path}: --map {one.target}={one.source}"
            raise InputError(f"there is no column {one.source!r}", where=where, do=f"the file has {_listed(table)}")
    used = {one.source for one in maps}
    kept = {name: column for name, column in sources.items() if name and name not in used and not is_truth(name)}
    return pa.table(kept | {one.target: sources[one.source] for one in maps})


def _check_names(path: Path, table: pa.Table) -> None:
    names = table.column_names
    sensors = numbers("mag", names)
    if sensors and any(name in names for name in mag_names()):
        what = "holds both mag_x_nT … and mag1_x_nT …: one magnetometer or an array?"
        raise InputError(what, where=str(path), do="keep one of the two, or rename the other")
    wanted = ["time_s", *(name for k in sensors for name in mag_names(k))] if sensors else ["time_s", *mag_names()]
    for name in wanted:
        if name not in names:
            what = f"there is no column {name}; the file has {_listed(table)}"
            example = name.replace("mag_", "b").replace("_nT", "") if name.startswith("mag") else "t"
            unit = "uT" if name.startswith("mag") else "ms"
            raise InputError(what, where=str(path), do=f"name it with --map {name}={example},unit={unit}")


def _listed(table: pa.Table) -> str:
    fields = [f"{f.name} ({f.type})" if pa.types.is_nested(f.type) else f.name for f in table.schema if f.name]
    return ", ".join(fields[:20]) + (f" and {len(fields) - 20} more" if len(fields) > 20 else "") or "no columns"


def _numeric(path: Path, table: pa.Table, maps: dict[str, ColumnMap]) -> dict[str, NDArray[Any]]:
    """Columns as float64 with NaN where a cell is empty, converted; `phase` as text."""
    named: dict[str, NDArray[Any]] = {}
    for name in table.column_names:
        column = table.column(name)
        if name == "phase":
            named[name] = np.array([str(word) if word is not None else "" for word in column.to_pylist()], np.str_)
            continue
        values = _floats(path, name, column)
        if values is not None:
            named[name] = maps[name].convert(values) if name in maps else values
    return named


def _floats(path: Path, name: str, column: pa.ChunkedArray) -> Array | None:
    """A column as float64; None for an optional one without values, and for a channel of text."""
    kind, required = column.type, name == "time_s" or group_of(name) == "mag"
    if column.null_count == len(column):
        return np.full(len(column), np.nan) if required else None
    if name == "time_s" and pa.types.is_timestamp(kind):
        return _seconds(column)
    if (pa.types.is_primitive(kind) and not pa.types.is_temporal(kind)) or pa.types.is_decimal(kind):
        return np.array(column.cast(pa.float64(), safe=False).to_numpy(), np.float64)
    refusal = _not_numbers(column)
    if group_of(name) != "channel" or refusal[0].startswith("row"):
        raise InputError(refusal[0], where=f"{path}: {name}", do=refusal[1])
    return None


def _seconds(column: pa.ChunkedArray) -> Array:
    """Seconds since the first of the timestamps."""
    at_ns = column.cast(pa.timestamp("ns", column.type.tz))
    first = at_ns.drop_null()[0]
    return np.asarray(pc.subtract(at_ns, first).cast(pa.int64()).to_numpy() * 1e-9)


def _not_numbers(column: pa.ChunkedArray) -> tuple[str, str]:
    """What a column holds instead of numbers, and what to do; it begins with "row" where other rows are numbers."""
    if pa.types.is_nested(column.type):
        return f"holds {column.type}, not one number a row", "split it into one column a component"
    cells = [None if cell is None else str(cell)[:40] for cell in column.to_pylist()]
    wrong = next((row for row, cell in enumerate(cells) if cell is not None and not _is_number(cell)), None)
    if wrong is None:
        return "row 1 onward holds numbers stored as text", "store them as numbers"
    if any(cell is not None and _is_number(cell) for cell in cells):
        return f"row {wrong + 1} is {cells[wrong]!r}, not a number", "correct the cell, or leave it empty"
    return f"holds {cells[wrong]!r} and the like, not numbers", "map another column with --map"


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
