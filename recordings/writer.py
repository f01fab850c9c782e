"""Runs as Parquet files, written block by block in bounded memory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq
from numpy.typing import NDArray

from recordings.assemble import arrays_of
from recordings.columns import RUN, columns_of, schema
from recordings.files import atomic_write, canonical_json, system_errors_about
from recordings.log_facts import LOG_KEY, NOTHING, LogFacts
from recordings.metadata import FORMAT, METADATA_KEY, RUNS_KEY, TRACKING_KEY, FileRun, Tracking
from recordings.recording import Recording
from recordings.url_path import Place
from scenarios.errors import InputError

ROWS_PER_GROUP = 65_536


class RunWriter:
    """Writer of one file, block by block; the file appears under its name only when the `with` block succeeds.

    Parameters
    ----------
    path : the final name; the file is written as `….magbench-part`, flushed and renamed.
    schema : see `columns.schema`.
    metadata : kept in the file as canonical JSON under the key `magbench`; log_facts : under `magbench_log`.
    shared : see `files.atomic_write`.

    Row groups have equal size however the blocks are cut, so equal data give equal bytes.
    Raises InputError where the operating system refuses to write, and then leaves nothing behind.
    """

    def __init__(
        self,
        path: Place,
        schema: pa.Schema,
        metadata: Mapping[str, Any],
        log_facts: LogFacts = NOTHING,
        shared: bool = False,
    ) -> None:
        self._path, self._shared = path, shared
        told = {LOG_KEY: canonical_json(log_facts.model_dump(mode="json"))} if log_facts else {}
        self._schema = schema.with_metadata({METADATA_KEY: canonical_json(metadata)} | told)
        self._floats = [field.name for field in schema if pa.types.is_floating(field.type)]
        self._buffer: dict[str, NDArray[Any]] = {}
        self._held = 0
        self._stack = ExitStack()

    def __enter__(self) -> RunWriter:
        with ExitStack() as stack:
            part = stack.enter_context(atomic_write(self._path, self._shared))
            with system_errors_about(self._path):
                self._sink: pa.OSFile = stack.enter_context(pa.OSFile(str(part), "wb"))
                self._parquet = self._open(self._sink)
            stack.push(self._close)
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.__exit__(kind, error, trace)

    def write(self, block: Mapping[str, NDArray[Any]]) -> None:
        """Append n samples: every column of the schema, each (n,)."""
        self._check(block)
        length, done = len(block[self._schema.names[0]]), 0
        while done < length:
            step = min(ROWS_PER_GROUP - self._held, length - done)
            for name in self._schema.names:
                self._room(name, block[name])[self._held : self._held + step] = block[name][done : done + step]
            self._held, done = self._held + step, done + step
            if self._held == ROWS_PER_GROUP:
                self._write_group()

    def add_tracking(self, tracking: Tracking | None) -> None:
        """Store the tracking error of the vehicle in the file's metadata."""
        if tracking is not None:
            self._parquet.add_key_value_metadata({TRACKING_KEY: canonical_json(asdict(tracking))})

    def add_runs(self, runs: Sequence[FileRun]) -> None:
        """Store the runs of a file of several in the file's metadata."""
        told = [vars(run) | {"parameters": run.parameters.model_dump(exclude_unset=True)} for run in runs]
        tables = [one | {"tracking": one["tracking"] and asdict(one["tracking"])} for one in told]
        self._parquet.add_key_value_metadata({RUNS_KEY: canonical_json(tables)})

    def _close(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Write the buffered rows and the footer; after an error only close the file, ignoring further errors."""
        with system_errors_about(self._path) if error is None else suppress(OSError), self._sink, self._parquet:
            if error is None:
                self._write_group()

    def _open(self, sink: pa.OSFile) -> pq.ParquetWriter:
        """Open with byte-stream split and zstd 1: a third of the time, two thirds of the size of pyarrow's defaults."""
        return pq.ParquetWriter(
            sink,
            self._schema,
            compression="zstd",
            compression_level=1,
            use_byte_stream_split=self._floats,
            use_dictionary=[name for name in self._schema.names if name not in self._floats],
            write_statistics=[name for name in (RUN.name, "time_s") if name in self._schema.names],
            write_page_checksum=True,
        )

    def _check(self, block: Mapping[str, NDArray[Any]]) -> None:
        if set(block) != set(self._schema.names):
            raise ValueError(f"columns differ from the schema: {sorted(set(block) ^ set(self._schema.names))}")
        lengths = {name: len(values) for name, values in block.items()}
        if len(set(lengths.values())) != 1:
            raise ValueError(f"columns of one block have different lengths: {lengths}")

    def _room(self, name: str, values: NDArray[Any]) -> NDArray[Any]:
        """Return the column's buffer; a text column's buffer widens when a longer word arrives."""
        held = self._buffer.get(name)
        dtype = np.dtype(np.float64) if name in self._floats else np.asarray(values).dtype
        if held is None:
            held = self._buffer[name] = np.empty(ROWS_PER_GROUP, dtype)
        elif dtype.itemsize > held.dtype.itemsize:
            held = self._buffer[name] = held.astype(dtype)
        return held

    def _write_group(self) -> None:
        if not self._held:
            return
        with system_errors_about(self._path):
            arrays = [_arrow(self._buffer[field.name][: self._held], field.type) for field in self._schema]
            self._parquet.write_batch(pa.record_batch(arrays, schema=self._schema))
            self._held = 0


def write_recording(recording: Recording, path: Path) -> None:
    """Write a recording without truth as Parquet or CSV, by the suffix of `path`; its directory is made.

    Raises InputError for another suffix and where the operating system refuses to write.
    """
    if path.suffix.lower() not in (".parquet", ".csv"):
        raise InputError(f"cannot write a recording as {path.suffix!r}", where=str(path), do="use .parquet or .csv")
    with system_errors_about(path.parent, "choose another directory"):
        path.parent.mkdir(parents=True, exist_ok=True)
    table = schema(columns_of(recording))
    arrays = arrays_of(recording)
    if path.suffix.lower() == ".parquet":
        with RunWriter(path, table, {"schema": FORMAT}, LogFacts.of(recording.origin)) as writer:
            writer.write(arrays)
    else:
        batch = pa.record_batch([pa.array(arrays[name]) for name in table.names], names=table.names)
        words = [*table.names, *np.unique(() if recording.phase is None else recording.phase)]
        quoting = "needed" if any(set(word) & set(',"\r\n') for word in words) else "none"
        options = pyarrow.csv.WriteOptions(quoting_style=quoting, quoting_header=quoting)
        with atomic_write(path) as part, system_errors_about(path):
            pyarrow.csv.write_csv(batch, str(part), options)


def _arrow(values: NDArray[Any], kind: pa.DataType) -> pa.Array:
    if not pa.types.is_dictionary(kind):
        return pa.array(values, kind)
    words, index = _words(values)
    return pa.DictionaryArray.from_arrays(pa.array(index, pa.int32()), pa.array(words, pa.string()))


def _words(values: NDArray[np.str_]) -> tuple[list[str], NDArray[np.int32]]:
    """Return the distinct words in order of appearance, and each row's index; fast for long runs of equal words."""
    starts = np.flatnonzero(np.r_[True, values[1:] != values[:-1]])
    words = list(dict.fromkeys(values[starts].tolist()))
    place = {word: i for i, word in enumerate(words)}
    stretch = np.array([place[word] for word in values[starts].tolist()], np.int32)
    return words, np.repeat(stretch, np.diff(np.r_[starts, len(values)]))
