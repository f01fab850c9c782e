"""A run out of a file that several runs share, as a file of its own."""

from __future__ import annotations

import json
from atexit import register
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from recordings.columns import RUN
from recordings.metadata import METADATA_KEY, FileRun, RunFile, file_runs
from recordings.readers import parquet_errors_about
from recordings.writer import RunWriter
from scenarios.errors import InputError

_FOLDERS: list[TemporaryDirectory[str]] = []
"""The process's directory of separated runs, made when first needed and removed at the end."""


def separate_run(file: Path, run: int) -> Path:
    """Return a file of one run of a joined file: the bytes that `simulate` writes without `--runs-per-file`.

    The file lies in a temporary directory, which the end of the process removes; rows of other runs are not read where
    the row groups can tell. Raises InputError for a file without the run, and for damaged files.
    """
    stat = file.stat()
    told = sha256(f"{file.resolve()} {stat.st_mtime_ns} {stat.st_size}".encode()).hexdigest()[:16]
    path = _folder() / told / f"run-{run:05d}.parquet"
    if not path.exists():
        path.parent.mkdir(exist_ok=True)
        _write(path, file, _entry(file, run))
    return path


def _folder() -> Path:
    if not _FOLDERS:
        _FOLDERS.append(TemporaryDirectory(prefix="magbench-runs-"))
        register(_FOLDERS[0].cleanup)
    return Path(_FOLDERS[0].name)


def _entry(file: Path, run: int) -> FileRun:
    """Return what a joined file tells of a run; InputError for another file."""
    held = {one.run: one for one in file_runs(file, RunFile(run, file.name, 0, 0, ""))}
    if run not in held:
        raise InputError(f"holds no run {run}", where=str(file), do="repeat the `simulate` command: it is made anew")
    return held[run]


def _write(path: Path, file: Path, entry: FileRun) -> None:
    """Write the rows of a run, without the column of its number, under the metadata of a run alone."""
    with parquet_errors_about(file):
        wanted = [(RUN.name, "=", entry.run)]
        table = pq.read_table(file, filters=wanted, page_checksum_verification=True).drop_columns([RUN.name])
    own: dict[str, Any] = json.loads(table.schema.metadata[METADATA_KEY.encode()])
    own |= {"run": entry.run, "parameters": entry.parameters.model_dump(exclude_unset=True)}
    with RunWriter(path, table.schema, own) as writer:
        writer.write({name: _plain(table.column(name)).to_numpy() for name in table.column_names})
        writer.add_tracking(entry.tracking)


def _plain(column: pa.ChunkedArray) -> pa.ChunkedArray:
    """Return a column of words spelt out, any other as it is."""
    return column.cast(pa.string()) if pa.types.is_dictionary(column.type) else column
