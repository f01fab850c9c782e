"""Arrays of any shape as the columns of a table: vectors split into x, y, z, one length chosen among several."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from recordings.column_words import ColumnName
from recordings.columns import mag_names
from recordings.names import guessed_maps
from scenarios.errors import InputError

Arrays = Mapping[str, NDArray[Any]]
PARTS = {3: "xyz", 4: "wxyz"}
"""Names of the columns of an array, by their number."""
TIMED = ("time", "x", "y", "z")
"""Of four columns whose first rises throughout, as no component of a quaternion does."""
MOST_COLUMNS = 30
"""An array with more columns is no set of vectors, but a picture or a spectrum."""
LEAST_ROWS = 5
"""Shorter arrays are parameters."""


def columns_of(name: str, values: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """Return an array (n,), (n, k) or (k, n) as columns of n numbers; empty for parameters, words and higher shapes.

    Three columns are `name_x`, `name_y`, `name_z`; four are w, x, y, z, or time, x, y, z; others are numbered from 1.
    """
    if values.dtype.kind not in "fiub" or max(values.shape, default=0) < LEAST_ROWS:
        return {}
    flat = np.squeeze(values)
    if flat.ndim == 1:
        return {name: flat}
    if flat.ndim != 2 or min(flat.shape) > MOST_COLUMNS:
        return {}
    block = flat if flat.shape[0] >= flat.shape[1] else flat.T
    parts: Sequence[str | int] = PARTS.get(block.shape[1], range(1, block.shape[1] + 1))
    if block.shape[1] == len(TIMED) and np.all(np.diff(block[:, 0]) > 0):
        parts = TIMED
    return {f"{name}_{part}": column for part, column in zip(parts, block.T, strict=True)}


def table_of(columns: Arrays, units: Mapping[str, str] | None = None) -> pa.Table:
    """Return columns of one length as a table of float64, units in the metadata of the fields."""
    told = units or {}
    fields = [
        pa.field(name, pa.float64(), metadata={"unit": told[name]} if told.get(name) else None) for name in columns
    ]
    arrays = [pa.array(np.asarray(values, np.float64), from_pandas=True) for values in columns.values()]
    return pa.table(arrays, schema=pa.schema(fields))


def chosen_rows(columns: Arrays) -> int:
    """Return the length of the columns that hold a magnetometer, else the commonest length; 0 without columns."""
    counts: dict[int, int] = {}
    for values in columns.values():
        counts[len(values)] = counts.get(len(values), 0) + 1
    lengths = sorted(counts, key=lambda rows: (-counts[rows], -rows))
    return next((rows for rows in lengths if has_magnetometer(_of_length(columns, rows))), next(iter(lengths), 0))


def has_magnetometer(names: Iterable[str]) -> bool:
    """Return whether columns of numbers are a magnetometer's by their names."""
    named = list(names)
    if mag_names()[0] in named or mag_names(1)[0] in named:
        return True
    empty = pa.table({name: pa.array([], pa.float64()) for name in named if ColumnName(name).words})
    try:
        return any(one.target == mag_names()[0] for one in guessed_maps(empty, ()))
    except InputError:  # two magnetometers as likely: the importer asks
        return True


def _of_length(columns: Arrays, rows: int) -> list[str]:
    return [name for name, values in columns.items() if len(values) == rows]
