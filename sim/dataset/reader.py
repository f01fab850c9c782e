"""Reading: recordings and runs from files and dataset directories."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from scenarios.errors import InputError
from sim.dataset.assemble import named_arrays, recording_of, truth_of
from sim.dataset.columns import RECORDING_GROUPS, TRUE_ATTITUDE, TRUE_FIELD, TRUE_POSITION, group_of, is_truth
from sim.dataset.files import system_errors_about
from sim.dataset.importer import read_measured
from sim.dataset.manifest import read_manifest, read_metadata, run_path
from sim.dataset.recording import Recording, Truth
from sim.dataset.tabular import damaged, is_parquet

_GROUPS = (*RECORDING_GROUPS, "channel")


def read_recording(
    path: Path, *, run: int = 0, groups: Sequence[str] | None = None, maps: Sequence[str] = ()
) -> Recording:
    """Read what an instrument gives, never the truth: from a run, a dataset directory (its `run`), or a measured log.

    groups : the column groups wanted, of `columns.GROUPS` (time and mag always come); others are not read from a run.
    maps : `--map` texts; with them, and for files that magbench did not write, `read_measured` checks and converts.
    Raises InputError for what cannot be read.
    """
    file = _file(path, run)
    if maps or not _is_ours(file):
        recording = read_measured(file, maps)
    else:
        recording = recording_of(_read(file, _wanted(_names(file), groups)))
    pa.default_memory_pool().release_unused()  # twice what a long log takes would stay with Arrow
    return recording


def read_run(path: Path, *, run: int = 0) -> tuple[Recording, Truth]:
    """Read a simulated run with its truth, from its file or from a dataset directory.

    Raises InputError where the file holds no truth.
    """
    file = _file(path, run)
    names = _names(file) if _is_ours(file) else []
    if not set(names) >= {*TRUE_FIELD, *TRUE_ATTITUDE, *TRUE_POSITION}:
        do = "give a run that `magbench simulate` wrote"
        raise InputError("holds no truth: it is a recording only", where=str(file), do=do)
    named = _read(file, names)
    return recording_of(named), truth_of(named, (read_metadata(file) or {}).get("parameters", {}))


def iter_blocks(
    path: Path, *, run: int = 0, rows: int = 65_536, groups: Sequence[str] | None = None
) -> Iterator[Recording]:
    """Read a run in blocks of at most `rows` samples, in bounded memory."""
    file = _file(path, run)
    if not _is_ours(file):
        raise InputError("is not a run of a dataset", where=str(file), do="read a measured log in one piece")
    with system_errors_about(file, "check the file"), pq.ParquetFile(file) as parquet:
        for batch in parquet.iter_batches(rows, columns=_wanted(_names(file), groups)):
            yield recording_of(named_arrays(pa.Table.from_batches([batch])))


def _file(path: Path, run: int) -> Path:
    if not path.is_dir():
        return path
    manifest, file = read_manifest(path), run_path(path, run)
    if not 0 <= run < manifest.runs:
        raise InputError(f"has no run {run}", where=str(path), do=f"it has runs 0 to {manifest.runs - 1}")
    if not file.exists():
        raise InputError(f"run {run} is not there yet", where=str(path), do="repeat the `simulate` command: it resumes")
    return file


def _is_ours(file: Path) -> bool:
    if not is_parquet(file):
        return False
    with damaged(file):
        return read_metadata(file) is not None


def _names(file: Path) -> list[str]:
    return list(pq.read_schema(file).names)


def _wanted(names: Sequence[str], groups: Sequence[str] | None) -> list[str]:
    if groups is not None and (unknown := set(groups) - set(_GROUPS)):
        raise ValueError(f"no such column groups: {sorted(unknown)}; there are {', '.join(_GROUPS)}")
    chosen = set(_GROUPS if groups is None else (*groups, "time", "mag"))
    return [name for name in names if not is_truth(name) and group_of(name) in chosen]


def _read(file: Path, names: Sequence[str]) -> dict[str, Any]:
    with damaged(file):
        return named_arrays(pq.read_table(file, columns=list(names), partitioning=None))


def parameters_of(path: Path, *, run: int = 0) -> dict[str, Any]:
    """The true parameters that a simulated run's file tells of; empty for a measured log."""
    file = _file(path, run)
    return dict((read_metadata(file) or {}).get("parameters", {})) if _is_ours(file) else {}
