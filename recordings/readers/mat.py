"""MATLAB's .mat files: v4 by scipy, v5 to v7, v7.3 by pymatreader; structs become dotted names, vectors x, y, z."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.files import system_errors_about
from recordings.readers.array_columns import chosen_rows, columns_of, table_of
from recordings.readers.base import FileContents, FileFormat, Wanted, library, stripped_names
from recordings.readers.damage import MOST_VALUES, check_values, library_errors_about
from recordings.readers.mat5 import MOST_DEPTH, DamagedMatError, arrays_of
from scenarios.errors import InputError

HDF_MARK, HDF_AT = b"\x89HDF\r\n\x1a\n", 512
"""The mark of HDF5 behind the text of a v7.3 header."""
ENDIAN = (b"\x00\x01IM", b"\x01\x00MI")
"""Version and byte order at byte 124 of v5 to v7."""
V4_HEADER = 20
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
    kept = {name: values for name, values in columns.items() if len(values) == rows}
    stripped_names(path, list(kept))
    check_values(path, rows * len(kept))
    others = len(columns) - len(kept)
    notes = (f"{others} arrays of other lengths than the magnetometer's {rows} rows left out",) if others else ()
    return FileContents({"": table_of(kept)}, notes)


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
        return dict(_flattened("", _hdf_variables(path), 0))
    if data[124:128] not in ENDIAN:
        with library_errors_about(path, _FORM):
            from scipy.io import loadmat

            return dict(_flattened("", loadmat(path), 0))
    try:
        return arrays_of(data, 8 * MOST_VALUES)
    except DamagedMatError as error:
        raise InputError(f"is cut off or damaged {_FORM}: {error}", where=str(path), do="save it again") from error


def _hdf_variables(path: Path) -> Mapping[str, Any]:
    reader, h5py = library(path, "pymatreader", "mat"), library(path, "h5py", "mat")
    with library_errors_about(path, _FORM):
        with h5py.File(path, "r") as file:
            sizes: list[int] = []
            file.visititems(lambda name, item: sizes.append(int(getattr(item, "size", 0) or 0)))
        check_values(path, sum(sizes))
        return dict(reader.read_mat(path))


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
