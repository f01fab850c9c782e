"""Rows of a run in a dataset's file: only the asked columns and row groups are read, from mapped memory.

Before its first row is read, a file is compared with the SHA-256 that the manifest lists.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from recordings.files import remembered_sha256
from recordings.readers import parquet_errors_about
from recordings.url_path import Place, arrow_source
from scenarios.errors import InputError

FILES_OPEN = 64
"""Files whose footers are kept; a footer of some 50 columns takes some 50 kB."""
GROUPS_KEPT = 2
"""Row groups that are kept decoded, so that the windows of neighbouring runs decode each group once."""
Rows = dict[str, NDArray[Any]]
"""Column -> its values (n,)."""


@dataclass(frozen=True)
class RunPlace:
    """Where a run lies: the file, the row of its first sample and the number of samples.

    sha256 : of the file by the manifest; None for a file that is read without a check.
    """

    run: int
    file: Place
    first: int
    rows: int
    sha256: str | None = None


def rows_of(place: RunPlace, columns: Sequence[str]) -> Rows:
    """Return columns of a run; InputError for a missing or damaged file."""
    check_file(place)
    with parquet_errors_about(place.file):
        starts = _starts(place.file)
        first, last = np.searchsorted(starts, (place.first, place.first + place.rows - 1), side="right") - 1
        groups = [_group(place.file, int(group), tuple(columns)) for group in range(first, last + 1)]
        begin = place.first - int(starts[first])
        table = pa.concat_tables(groups).slice(begin, place.rows)
        return {name: _values(table.column(name)) for name in columns}


def file_rows(place: RunPlace, columns: Sequence[str]) -> Rows:
    """Return columns of all runs of a place's file; InputError for a missing or damaged file."""
    check_file(place)
    with parquet_errors_about(place.file), arrow_source(place.file) as source:
        table = pq.read_table(source, columns=list(columns), memory_map=True, partitioning=None)
    return {name: _values(table.column(name)) for name in columns}


def check_file(place: RunPlace) -> None:
    """Compare a run's file with its SHA-256, once until the file changes; InputError where they differ."""
    if place.sha256 is not None:
        with parquet_errors_about(place.file):
            found = remembered_sha256(place.file)
        if found != place.sha256:
            do = "copy the file again, or remove it and repeat the `simulate` command; check=False reads it as it is"
            raise InputError("differs from its SHA-256 in dataset.json", where=str(place.file), do=do)


@lru_cache(FILES_OPEN)
def _opened(file: Place) -> pq.ParquetFile:
    return pq.ParquetFile(file if isinstance(file, Path) else file.open(), memory_map=True)


@lru_cache(FILES_OPEN)
def _starts(file: Place) -> NDArray[np.int64]:
    """Return the first row of each row group."""
    about = _opened(file).metadata
    sizes = [about.row_group(k).num_rows for k in range(about.num_row_groups)]
    return np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)[:-1]])


@lru_cache(GROUPS_KEPT)
def _group(file: Place, group: int, columns: tuple[str, ...]) -> pa.Table:
    return _opened(file).read_row_group(group, columns=list(columns))


def _values(column: pa.ChunkedArray) -> NDArray[Any]:
    """Return the values, without a copy where they are numbers in one chunk."""
    if pa.types.is_dictionary(column.type):
        words = column.cast(pa.string()).to_numpy()
        return np.asarray(words, dtype=str)
    return np.asarray(column.chunk(0).to_numpy() if column.num_chunks == 1 else column.to_numpy())
