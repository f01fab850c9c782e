"""Parquet and CSV files of any origin as Arrow tables, with one clear line for what cannot be read."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq

from recordings.files import system_errors_about
from scenarios.errors import InputError
from scenarios.files import check_regular

PARQUET_MARK = b"PAR1"
_TEXT_SUFFIXES = (".csv", ".tsv", ".txt")
_RAGGED = re.compile(r"(?:Row #(\d+): )?Expected (\d+) columns, got (\d+)")
_AUTOPILOTS = {
    ".ulg": "convert it with ulog2csv of pyulog, and join attitude and currents to the magnetometer's times",
    ".bin": "convert it with mavlogdump.py of pymavlink, and join attitude and currents to the magnetometer's times",
}
"""What turns an autopilot's own log into a table, by the suffix."""
_FORMATS = "give a Parquet file (.parquet) or a text table with a header line (.csv, .tsv, .txt)"


def is_parquet(path: Path) -> bool:
    """Whether a file begins as Parquet does; InputError where it cannot be opened."""
    return _head(path, len(PARQUET_MARK)) == PARQUET_MARK


def load_table(path: Path, wanted: Callable[[str], bool]) -> pa.Table:
    """Read the wanted columns of a Parquet file, or of a CSV file (comma, semicolon or tab, first line the header).

    Blanks around the names are removed. Raises InputError for a file that is missing, a directory, unreadable, empty,
    damaged, of another kind, or ragged, and for two columns of one name.
    """
    if is_parquet(path):
        table = _load_parquet(path, wanted)
    elif path.suffix.lower() in _TEXT_SUFFIXES:
        table = _load_csv(path)
    else:
        do = _AUTOPILOTS.get(path.suffix.lower(), _FORMATS)
        raise InputError("is neither Parquet nor CSV", where=str(path), do=do)
    return table.select([name for name in table.column_names if wanted(name)])


@contextmanager
def damage_named(path: Path) -> Iterator[None]:
    """Turns what Arrow says of a damaged or missing Parquet file into an InputError about `path`."""
    try:
        yield
    except FileNotFoundError as error:
        raise InputError("no such file", where=str(path), do="check the path") from error
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        do = "copy or convert it again; a file that was cut off while being written cannot be read"
        raise InputError("is cut off or damaged Parquet", where=str(path), do=do) from error


def _load_parquet(path: Path, wanted: Callable[[str], bool]) -> pa.Table:
    """Only the wanted columns are read; those that are must hold what their types say, or a look at them may crash."""
    with damage_named(path), pq.ParquetFile(path) as file:
        names = list(file.schema_arrow.names)
        stripped = _stripped(path, names)
        chosen = [name for name in names if wanted(name.strip())]
        table = file.read(columns=chosen)
        table.validate(full=True)
    return table.rename_columns([stripped[name] for name in table.column_names])


def _head(path: Path, length: int) -> bytes:
    if path.is_dir():
        do = "give a file, or a directory that `magbench simulate` wrote"
        raise InputError("is a directory, not a recording", where=str(path), do=do)
    with system_errors_about(path, "check the path and the permissions"):
        check_regular(path)
        with path.open("rb") as file:
            head = file.read(length)
    if not head:
        raise InputError("is empty", where=str(path), do=_FORMATS)
    return head


def _load_csv(path: Path) -> pa.Table:
    header = _header(path)
    try:
        table = pyarrow.csv.read_csv(
            path,
            read_options=pyarrow.csv.ReadOptions(use_threads=False),
            parse_options=pyarrow.csv.ParseOptions(delimiter=_delimiter(header), ignore_empty_lines=True),
        )
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        raise _csv_error(path, error) from error
    _stripped(path, table.column_names)
    return table.rename_columns([name.strip() for name in table.column_names])


def _header(path: Path) -> str:
    first = _head(path, 1 << 16).split(b"\n", 1)[0]
    try:
        header = first.decode("utf-8-sig").strip()
    except UnicodeDecodeError as error:
        raise InputError("is not a text table", where=str(path), do=_FORMATS) from error
    if "\0" in header:
        raise InputError("is not a text table", where=str(path), do=_FORMATS)
    if any(_is_number(cell) for cell in header.split(_delimiter(header))):
        do = "put the names of the columns in the first line: time_s,mag_x_nT,mag_y_nT,mag_z_nT,…"
        raise InputError(f"has no header: the first line is {header[:60]!r}", where=str(path), do=do)
    return header


def _delimiter(header: str) -> str:
    return max((",", ";", "\t"), key=header.count)


def _is_number(cell: str) -> bool:
    try:
        float(cell.strip().strip('"'))
    except ValueError:
        return False
    return True


def _csv_error(path: Path, error: Exception) -> InputError:
    ragged = _RAGGED.search(str(error))
    if ragged:
        line, expected, actual = ragged.groups()
        what = f"{f'line {line}' if line else 'a line'} has {actual} cells, the header has {expected}"
        return InputError(what, where=str(path), do="repair or remove the line; all columns must have the same length")
    reason = re.sub(r"\s+", " ", str(error))[:160]
    return InputError(f"cannot be read as CSV: {reason}", where=str(path), do=_FORMATS)


def _stripped(path: Path, names: Sequence[str]) -> dict[str, str]:
    """Each name without the blanks around it; InputError where two columns then have the same."""
    stripped = [name.strip() for name in names]
    twice = [name for name, count in Counter(stripped).items() if count > 1]
    if twice:
        raise InputError("there are two columns of this name", where=f"{path}: {twice[0]}", do="rename one of them")
    return dict(zip(names, stripped, strict=True))
