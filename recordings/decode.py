"""Arrow columns of any type as numbers or as words."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from scenarios.arrays import Array

MAX_WORD = 200
"""Longest word of a text column; numpy gives every row the memory of the longest."""
_PER_SECOND = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}


class NotNumbersError(Exception):
    """A column does not hold numbers: what was found, and what to do; `mixed` where some rows are numbers."""

    def __init__(self, what: str, do: str, *, mixed: bool = False) -> None:
        super().__init__(what)
        self.what, self.do, self.mixed = what, do, mixed


def numbers_of(column: pa.ChunkedArray) -> Array:
    """Return the column as float64 (n,), NaN for an empty cell; NotNumbersError for other content than numbers."""
    if pa.types.is_dictionary(column.type):
        column = column.cast(column.type.value_type)
    if is_empty(column):
        return np.full(len(column), np.nan)
    kind = column.type
    if not (pa.types.is_decimal(kind) or pa.types.is_primitive(kind)) or pa.types.is_temporal(kind):
        raise _refusal(column)
    return _filled(column.cast(pa.float64(), safe=False))


def _filled(column: pa.ChunkedArray) -> Array:
    """The values of a column of float64, NaN for an empty cell; Arrow's own conversion loads pandas, half a second."""
    parts = [_values(chunk) for chunk in column.chunks if len(chunk)]
    return parts[0] if len(parts) == 1 else np.concatenate([np.empty(0), *parts])


def _values(chunk: pa.DoubleArray) -> Array:
    if chunk.null_count == len(chunk):
        return np.full(len(chunk), np.nan)
    values = np.frombuffer(chunk.buffers()[1], np.float64, len(chunk), 8 * chunk.offset)
    if not chunk.null_count:
        return values
    return np.where(chunk.is_null().to_numpy(zero_copy_only=False), np.nan, values)


def seconds_of(column: pa.ChunkedArray) -> Array:
    """Return seconds (n,) since the first of a column of timestamps, NaN for an empty cell."""
    first = column.drop_null()[0]
    ticks = pc.subtract_checked(column, first).cast(pa.int64())
    return np.asarray(ticks.to_numpy() / _PER_SECOND[column.type.unit])


def start_of(column: pa.ChunkedArray) -> float:
    """Return seconds since 1970 of the first of a column of timestamps; those without a zone count as UTC."""
    return float(column.drop_null()[0].value) / _PER_SECOND[column.type.unit]


def words_of(column: pa.ChunkedArray) -> NDArray[np.str_]:
    """Return the column as text (n,), empty for an empty cell; NotNumbersError for a cell that is no word."""
    if pa.types.is_dictionary(column.type):
        whole = column.unify_dictionaries().combine_chunks()
        words = _words(whole.dictionary)
        index = whole.indices.fill_null(len(words)).to_numpy()
        return np.asarray(np.append(words, "")[index])
    return _words(column)


def is_empty(column: pa.ChunkedArray) -> bool:
    """Return whether no cell of the column has a value."""
    return bool(column.null_count == len(column))


def is_timestamp(column: pa.ChunkedArray) -> bool:
    """Return whether the column holds dates with a time of day."""
    return bool(pa.types.is_timestamp(column.type)) and not is_empty(column)


def _words(cells: pa.Array | pa.ChunkedArray) -> NDArray[np.str_]:
    if pa.types.is_nested(cells.type):
        raise NotNumbersError(f"holds {cells.type}, not one word a row", "store one word a row, or leave it out")
    words = [word or "" for word in cells.cast(pa.string()).to_pylist()]
    if any(len(word) > MAX_WORD for word in words):
        raise NotNumbersError(f"holds words of more than {MAX_WORD} characters", "shorten them, or leave it out")
    return np.array(words, np.str_)


def _refusal(column: pa.ChunkedArray) -> NotNumbersError:
    kind = column.type
    if pa.types.is_nested(kind):
        return NotNumbersError(f"holds {kind}, not one number a row", "split it into one column a component")
    if not (pa.types.is_string(kind) or pa.types.is_large_string(kind)):
        return NotNumbersError(f"holds {kind}, not numbers", "convert it, or map another column with --map")
    cells = column.to_pylist()
    wrong = next((row for row, cell in enumerate(cells) if cell is not None and not _is_number(cell)), None)
    if wrong is None:
        return NotNumbersError("row 1 onward holds numbers stored as text", "store them as numbers", mixed=True)
    found = cells[wrong][:40]
    if any(cell is not None and _is_number(cell) for cell in cells):
        what = f"row {wrong + 1} is {found!r}, not a number"
        return NotNumbersError(what, "correct the cell, or leave it empty", mixed=True)
    return NotNumbersError(f"holds {found!r} and the like, not numbers", "map another column with --map")


def _is_number(cell: Any) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
