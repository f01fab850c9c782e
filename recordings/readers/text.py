"""Text tables: a header line, then one row a line, with commas, semicolons or tabs between the cells (CSV)."""

from __future__ import annotations

import re
from pathlib import Path

import pyarrow as pa
import pyarrow.csv

from recordings.readers.base import FileContents, FileFormat, Wanted, file_head, stripped_names
from scenarios.errors import InputError

DELIMITERS = (",", ";", "\t")
_SUFFIXES = (".csv", ".tsv", ".txt")
_CONVERT = "convert it to a text table with a header line, or to Parquet"
_RAGGED = re.compile(r"(?:Row #(\d+): )?Expected (\d+) columns, got (\d+)")


def _read(path: Path, wanted: Wanted) -> FileContents:
    """Read all columns: a text table has to be parsed whole, so `wanted` saves nothing."""
    try:
        table = pyarrow.csv.read_csv(
            path,
            read_options=pyarrow.csv.ReadOptions(use_threads=False),
            parse_options=pyarrow.csv.ParseOptions(delimiter=_delimiter(_header(path)), ignore_empty_lines=True),
        )
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        raise _unreadable(path, error) from error
    return FileContents({"": table.rename_columns(stripped_names(path, table.column_names))})


def _header(path: Path) -> str:
    """Return the first line; InputError for a binary file, and where a cell of the first line is a number."""
    try:
        header = file_head(path).split(b"\n", 1)[0].decode("utf-8-sig").strip()
    except UnicodeDecodeError as error:
        raise InputError("is not a text table", where=str(path), do=_CONVERT) from error
    if "\0" in header:
        raise InputError("is not a text table", where=str(path), do=_CONVERT)
    if any(_is_number(cell) for cell in header.split(_delimiter(header))):
        do = "put the names of the columns in the first line: time_s,mag_x_nT,mag_y_nT,mag_z_nT,…"
        raise InputError(f"has no header: the first line is {header[:60]!r}", where=str(path), do=do)
    return header


def _delimiter(header: str) -> str:
    return max(DELIMITERS, key=header.count)


def _is_number(cell: str) -> bool:
    try:
        float(cell.strip().strip('"'))
    except ValueError:
        return False
    return True


def _unreadable(path: Path, error: Exception) -> InputError:
    ragged = _RAGGED.search(str(error))
    if ragged:
        line, expected, actual = ragged.groups()
        what = f"{f'line {line}' if line else 'a line'} has {actual} cells, the header has {expected}"
        return InputError(what, where=str(path), do="repair or remove the line; all columns must have the same length")
    reason = re.sub(r"\s+", " ", str(error))[:160]
    return InputError(f"cannot be read as CSV: {reason}", where=str(path), do=_CONVERT)


TEXT = FileFormat(
    name="CSV",
    suffixes=_SUFFIXES,
    summary="a text table with a header line",
    recognises=lambda path, head: path.suffix.lower() in _SUFFIXES,
    read=_read,
)
