"""MATLAB's .mat files: v4 by scipy, v5 to v7, v7.3 by h5py; structs become dotted names, vectors x, y, z."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.column_words import TIMES, ColumnName
from recordings.files import system_errors_about
from recordings.readers.array_columns import chosen_rows, columns_of, table_of
from recordings.readers.base import FileContents, FileFormat, Wanted, library, stripped_names
from recordings.readers.damage import (
    MOST_VALUES,
    check_expansion,
    check_values,
    library_errors_about,
    most_expanded,
)
from recordings.readers.hdf5 import MOST_ATTRIBUTE, attribute_bytes, data_sets, declared_bytes
from recordings.readers.mat5 import MOST_DEPTH, DamagedMatError, Found, arrays_of
from scenarios.errors import InputError

HDF_MARK, HDF_AT = b"\x89HDF\r\n\x1a\n", 512
"""The mark of HDF5 behind the text of a v7.3 header."""
ENDIAN = (b"\x00\x01IM", b"\x01\x00MI")
"""Version and byte order at byte 124 of v5 to v7."""
TEXTS = (b"char", b"cell", b"string")
"""Classes of v7.3 whose numbers are letters or references."""
V4_HEADER = 20
DAY_1970, DAYS, MOST_DAYS = 719_529.0, (693_962.0, 767_010.0), 1000.0
"""Days of MATLAB's calendar: 1 January 1970, those of 1900 to 2100, and the most that a log lasts."""
_FORM = "MATLAB data"


def _recognises(path: Path, head: bytes) -> bool:
    return head[124:128] in ENDIAN or _is_hdf(head) or (path.suffix.lower() == ".mat" and _is_v4(head))


def _is_hdf(head: bytes) -> bool:
    return head.startswith(b"MATLAB 7.3") and head[HDF_AT : HDF_AT + 8] == HDF_MARK


def _is_v4(head: bytes) -> bool:
    """Return whether the first bytes are the header of a v4 matrix: type, rows, columns, imaginary, length of name.

    The decimal digits of the type are the byte order, 0, the numbers' type 0 to 5, and the matrix' kind 0 to 2.
    """
    return len(head) >= V4_HEADER and any(_is_v4_header(head, order) for order in "<>")


def _is_v4_header(head: bytes, order: str) -> bool:
    kind, rows, columns, imaginary, length = np.frombuffer(head, f"{order}i4", 5).tolist()
    digits = 0 <= kind < 5000 and kind % 1000 < 60 and kind % 10 < 3
    shape = rows > 0 and columns > 0 and imaginary in (0, 1)
    return digits and shape and 0 < length < 64 and head[V4_HEADER : V4_HEADER + length].endswith(b"\0")


def _read(path: Path, wanted: Wanted, stream: str | None) -> FileContents:
    """Return the columns as long as the magnetometer's, under the names of the file; a struct's fields with dots."""
    columns = {name: values for name, values in _columns(path).items() if wanted(name)}
    rows = chosen_rows(columns)
    if not rows:
        raise InputError("holds no array of numbers", where=str(path), do="save the measured arrays with it")
    kept = {name: _seconds(name, values) for name, values in columns.items() if len(values) == rows}
    stripped_names(path, list(kept))
    check_values(path, rows * len(kept))
    others = len(columns) - len(kept)
    notes = (f"{others} arrays of other lengths than the magnetometer's {rows} rows left out",) if others else ()
    return FileContents({"": table_of(kept)}, notes)


def _seconds(name: str, values: NDArray[Any]) -> NDArray[Any]:
    """Return times in days of MATLAB's calendar, as `datenum` gives them, in seconds since 1970; others as they are."""
    words = ColumnName(name.rpartition(".")[2]).words
    days = values.astype(np.float64)
    known = days[np.isfinite(days)]
    if not set(words) & {*TIMES, "datenum"} or not len(known) or not DAYS[0] < known.min() <= known.max() < DAYS[1]:
        return values
    return (days - DAY_1970) * 86_400.0 if known[-1] - known[0] < MOST_DAYS else values


def _columns(path: Path) -> dict[str, NDArray[Any]]:
    found: dict[str, NDArray[Any]] = {}
    for name, values in _arrays(path).items():
        found |= columns_of(name, values)
    return found


def _arrays(path: Path) -> Mapping[str, NDArray[Any]]:
    """Return the arrays of a file by name; fields of structs behind dots."""
    with system_errors_about(path, "check the path and the permissions"):
        data = path.read_bytes()
    if _is_hdf(data):
        return _hdf_arrays(path)
    if data[124:128] not in ENDIAN:
        with library_errors_about(path, _FORM):
            from scipy.io import loadmat

            return dict(_flattened("", loadmat(path), 0))
    try:
        return arrays_of(data, min(8 * MOST_VALUES, most_expanded(len(data))))
    except DamagedMatError as error:
        raise InputError(f"cannot be read as {_FORM}: {error}", where=str(path), do="save it again") from error


def _hdf_arrays(path: Path) -> Found:
    """Return the arrays of a v7.3 file by their names, in the shape that MATLAB shows; words and cells are left out."""
    h5py = library(path, "h5py", "mat")
    with library_errors_about(path, _FORM), h5py.File(path, "r") as file:
        found = dict(data_sets(h5py, file, MOST_DEPTH, str(path)))
        numeric = {name: item for name, item in found.items() if _is_numeric(name, item)}
        check_values(path, sum(map(declared_bytes, numeric.values())) // 8)
        check_expansion(path, sum(map(declared_bytes, numeric.values())))
        return {name: np.asarray(item[()]).T for name, item in numeric.items()}


def _is_numeric(name: str, item: Any) -> bool:
    """Return whether a data set of numbers is an array: no text, no content of a cell, and not MATLAB's mark of [].

    The attributes of the data set tell, in few bytes.
    """
    large = any(attribute_bytes(item.attrs, key) > MOST_ATTRIBUTE for key in item.attrs)
    text = large or np.bytes_(item.attrs.get("MATLAB_class", b"")) in TEXTS
    return not (text or name.startswith("#") or "MATLAB_empty" in item.attrs)


def _flattened(name: str, value: Any, depth: int) -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield arrays with their dotted names; a list of structs, as cells and arrays of structs are, is not read."""
    if isinstance(value, Mapping) and depth <= MOST_DEPTH:
        for key, part in value.items():
            if not str(key).startswith("__"):
                yield from _flattened(f"{name}.{key}" if name else str(key), part, depth + 1)
    elif isinstance(value, np.ndarray):
        yield name, value


MAT = FileFormat(
    name="MATLAB",
    suffixes=(".mat",),
    summary="a MATLAB file",
    extra="mat",
    remark="structs and vectors taken apart; names as in text tables",
    recognises=_recognises,
    read=_read,
)
