"""The table of runs: a row a run, with file, part, and a column for every true parameter and drawn value."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from recordings.files import atomic_write, system_errors_about
from recordings.manifest import Manifest
from recordings.metadata import FileRun, RunFile, TrueParameters, file_runs
from recordings.url_path import Place

RUNS = "runs.parquet"
ROWS_AT_ONCE = 1000
"""Rows in memory, and in a row group."""
FIXED = {
    "run": (pa.int64(), "number of the run"),
    "split": (pa.string(), "train, validation or test"),
    "file": (pa.string(), "the run's file, seen from this directory"),
    "seed": (pa.int64(), "seed of the dataset: with the number of the run it gives the run again"),
    "rows": (pa.int64(), "samples of the run"),
    "tracking_rms_m": (pa.float64(), "how far the vehicle was from its path; null where it follows none"),
    "tracking_max_m": (pa.float64(), "the same, at most"),
}
"""Columns of every dataset: type and meaning."""
Cell = str | float | bool
Row = dict[str, Any]


def write_runs_table(out: Place, dataset: Manifest) -> None:
    """Write OUT/runs.parquet, in the order of the files; null where a run lacks a parameter.

    The files are read twice, first for the names of the columns, so that memory does not grow with the runs.
    """
    schema = _schema((flattened(held.parameters) for _, held in _runs(out, dataset)), dataset)
    path, found = out / RUNS, _runs(out, dataset)
    with (
        atomic_write(path) as part,
        system_errors_about(path),
        pq.ParquetWriter(part, schema, write_page_checksum=True) as writer,
    ):
        while rows := [_row(dataset, file, held) for file, held in islice(found, ROWS_AT_ONCE)]:
            writer.write_batch(pa.RecordBatch.from_pylist(rows, schema=schema))


def flattened(parameters: TrueParameters) -> dict[str, Cell]:
    """Return parameters by the dotted keys of scenario files, `--set` and `[vary]`, vectors and matrices by component.

    Effects have the keys `effects`, or for an array `effects1`, `effects2`, … as in the columns.
    """
    known = parameters.model_dump(exclude_unset=True)
    sensors = known.pop("effects", [])
    drawn, field_nT = known.pop("drawn", {}), known.pop("field_enu_nT", None)
    known.pop("effect_order", None)
    numbered = {f"effects{number}": tables for number, tables in enumerate(sensors, start=1)}
    effects = {"effects": sensors[0]} if len(sensors) == 1 else numbered
    return dict(_cells("", drawn)) | dict(_cells("", {"field": {"enu_nT": field_nT}, **known, **effects}))


def _cells(key: str, value: Any) -> Iterator[tuple[str, Cell]]:
    """Yield the numbers, booleans and words below a key, each under its full key."""
    if isinstance(value, list):
        value = dict(enumerate(value))
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _cells(f"{key}.{name}" if key else str(name), inner)
    elif value is not None:
        yield key, float(value) if isinstance(value, int) and not isinstance(value, bool) else value


def _runs(out: Place, dataset: Manifest) -> Iterator[tuple[RunFile, FileRun]]:
    """Yield every run with its file."""
    for file in dataset.files:
        yield from ((file, held) for held in file_runs(out / file.path, file))


def _schema(runs: Iterable[Mapping[str, Cell]], dataset: Manifest) -> pa.Schema:
    kinds: dict[str, pa.DataType] = {}
    for cells in runs:
        kinds |= {key: _kind(cell) for key, cell in cells.items() if key not in kinds}
    known = {name: about for name, about in FIXED.items() if name != "split" or dataset.split}
    fixed = [pa.field(name, kind, metadata={"meaning": meaning}) for name, (kind, meaning) in known.items()]
    return pa.schema([*fixed, *(pa.field(key, kind, metadata=_meaning(key)) for key, kind in kinds.items())])


def _kind(cell: Cell) -> pa.DataType:
    if isinstance(cell, bool):
        return pa.bool_()
    return pa.string() if isinstance(cell, str) else pa.float64()


def _meaning(key: str) -> dict[str, str]:
    return {"meaning": f"value of {key} in this run; units are in the name, components are numbered from 0"}


def _row(dataset: Manifest, file: RunFile, held: FileRun) -> Row:
    tracking, split = held.tracking, dataset.split
    return {
        "run": held.run,
        "split": split and split.part_of(held.run),
        "file": file.path,
        "seed": dataset.seed,
        "rows": held.rows,
        "tracking_rms_m": tracking and tracking.rms_m,
        "tracking_max_m": tracking and tracking.max_m,
        **flattened(held.parameters),
    }
