"""Baseline file of a gate: earlier scores of calibrators, trial by trial, as the reference of the limit."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from recordings.files import atomic_write, canonical_json, system_errors_about
from recordings.readers import verified_table
from scenarios.arrays import Array
from scenarios.errors import InputError
from scenarios.toml import as_dict
from validation.comparison.design import Design

COLUMNS = pa.schema(
    [
        ("scenario", pa.string()),
        ("sha256", pa.string()),
        ("seed", pa.int64()),
        ("calibrator", pa.string()),
        ("score", pa.string()),
        ("run", pa.int64()),
        ("value", pa.float64()),
    ]
)
"""sha256 : digest of the whole scenario. value : null without an estimate."""
LARGEST = 1e12
"""Largest score of a baseline, in the score's unit: beyond every figure that a fit gives, far from overflow."""
ANEW = "write it anew with --write-baseline"


def rows_of(design: Design, calibrator: str, score: str, values: Array) -> pa.Table:
    """Return a calibrator's scores in runs 0 ... n - 1 as rows of a baseline."""
    n = len(values)
    same = {
        "scenario": design.points[-1].scenario.name,
        "sha256": _digest(design),
        "seed": design.seed,
        "calibrator": calibrator,
        "score": score,
    }
    columns = {key: [value] * n for key, value in same.items()}
    found = [float(value) if np.isfinite(value) else None for value in values]
    return pa.table(columns | {"run": list(range(n)), "value": found}, schema=COLUMNS)


def check_place(path: Path) -> None:
    """Refuse a baseline's path in a missing folder, or that is a folder; raises InputError."""
    if not path.parent.is_dir():
        raise InputError(f"no such directory: {path.parent}", where=str(path), do="make the directory first")
    if path.is_dir():
        raise InputError("is a directory", where=str(path), do="name a file")


def write_baseline(path: Path, parts: Iterable[pa.Table]) -> None:
    """Write a baseline atomically; InputError where the file cannot be written."""
    with atomic_write(path) as part, system_errors_about(path):
        pq.write_table(pa.concat_tables(parts), part, compression="zstd", write_page_checksum=True)


def read_baseline(path: Path, design: Design, calibrator: str, score: str, trials: int) -> Array:
    """Return a calibrator's score (trials,) in runs 0, 1, ...; infinite without an estimate.

    Raises InputError for a file that is no baseline, for a different scenario, seed, calibrator or score, and for too
    few trials.
    """
    table = _table(path)
    wanted = {"sha256": _digest(design), "seed": design.seed, "calibrator": calibrator, "score": score}
    words = {"sha256": "this scenario with these overrides", "seed": f"seed {design.seed}"}
    for column, value in wanted.items():
        table = table.filter(pc.equal(table[column], value))
        if not table.num_rows:
            what = words.get(column, f"{column} {value}")
            raise InputError(f"holds nothing of {what}", where=str(path), do=ANEW)
    _check_values(path, table)
    found = dict(zip(table["run"].to_pylist(), table["value"].to_pylist(), strict=True))
    missing = next((run for run in range(trials) if run not in found), None)
    if missing is not None:
        what = f"holds no run {missing}; the gate may take {trials} trials"
        raise InputError(what, where=str(path), do=f"{ANEW}, or lower max_trials")
    return np.array([np.inf if found[run] is None else found[run] for run in range(trials)])


def _table(path: Path) -> pa.Table:
    """Return a baseline's rows; InputError for a file that is no baseline, or whose pages' checksums do not match."""
    if not path.is_file():
        raise InputError("no such file", where=str(path), do="write it with --write-baseline")
    table = verified_table(path)
    if not table.schema.equals(COLUMNS):
        raise InputError("is no baseline", where=str(path), do=ANEW)
    return table


def _check_values(path: Path, table: pa.Table) -> None:
    """Refuse what no score can be: not finite, negative, or given twice for a run."""
    values, runs = table["value"].drop_null().to_numpy(), table["run"].to_pylist()
    if not np.all(np.isfinite(values) & (values >= 0.0) & (values <= LARGEST)):
        raise InputError("holds a score that is negative or not finite", where=str(path), do=ANEW)
    if len(set(runs)) < len(runs):
        raise InputError("holds a run twice", where=str(path), do=ANEW)


def _digest(design: Design) -> str:
    return hashlib.sha256(canonical_json(as_dict(design.points[-1].scenario)).encode()).hexdigest()
