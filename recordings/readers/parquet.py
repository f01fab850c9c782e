"""Parquet files of any origin."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from recordings.log_facts import FACTS, LOG_KEY
from recordings.readers.base import FileContents, FileFormat, Wanted, file_head, stripped_names
from scenarios.errors import InputError
from scenarios.files import validated

MARK = b"PAR1"
"""The first bytes of every Parquet file."""


def is_parquet(path: Path) -> bool:
    """Whether a file begins as Parquet does; InputError where the file cannot be opened."""
    return file_head(path).startswith(MARK)


@contextmanager
def parquet_errors_about(path: Path) -> Iterator[None]:
    """Turn Arrow's errors about a damaged or missing Parquet file into an InputError about `path`."""
    try:
        yield
    except FileNotFoundError as error:
        raise InputError("no such file", where=str(path), do="check the path") from error
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        do = "copy or convert it again; a file that was cut off while being written cannot be read"
        raise InputError("is cut off or damaged Parquet", where=str(path), do=do) from error


def _read(path: Path, wanted: Wanted, stream: str | None) -> FileContents:
    with parquet_errors_about(path), pq.ParquetFile(path) as file:
        names = file.schema_arrow.names
        stripped = dict(zip(names, stripped_names(path, names), strict=True))
        table = file.read(columns=[name for name in names if wanted(stripped[name])])
        table.validate(full=True)  # cells that contradict their column's type would crash Arrow later
        kept = (file.metadata.metadata or {}).get(LOG_KEY.encode())
    table = table.rename_columns([stripped[name] for name in table.column_names])
    return FileContents({"": table}) if kept is None else _of_log(path, table, kept)


def _of_log(path: Path, table: pa.Table, kept: bytes) -> FileContents:
    """Return the columns of a vehicle's log with what the log told of itself; InputError for damaged metadata."""
    do = "read the vehicle's log again with `magbench read`"
    facts = validated(FACTS, kept, f"{path}: metadata {LOG_KEY!r}", do)
    applied = {} if facts.applied is None else {facts.magnetometer: facts.applied.applied()}
    place = None if facts.place is None else tuple(facts.place)
    return FileContents(
        {facts.magnetometer: table},
        frame=facts.frame,
        unit=facts.unit,
        place=place,
        date=facts.date,
        applied=applied,
    )


PARQUET = FileFormat(
    name="Parquet",
    suffixes=(".parquet",),
    summary="a Parquet file",
    remark="the dataset's columns, or names as in text tables",
    recognises=lambda path, head: head.startswith(MARK),
    read=_read,
)
