"""Trials as an Arrow table of a row each, read from lines of a journal without an object for every number."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import asdict

import numpy as np
import pyarrow as pa
import pyarrow.json as arrow_json

from scenarios.errors import InputError
from validation.comparison.trial import Trial, TrialRow
from validation.scoring.definitions import SCORE_DEFINITIONS

COLUMNS = tuple(meaning.column for meaning in SCORE_DEFINITIONS.values())
"""Columns of all scores, in the order of the definitions."""
TIMES = ("wall_s", "cpu_s")
WORDS = ("status", "reason")
_ROW = pa.struct(
    {name: pa.string() for name in ("calibrator", *WORDS)}
    | {"scores": pa.struct(dict.fromkeys(COLUMNS, pa.float64()))}
    | dict.fromkeys(TIMES, pa.float64())
)
SCHEMA = pa.schema({"point": pa.int64(), "run": pa.int64(), "rows": pa.list_(_ROW)})
"""A `Trial`: a missing score is null."""


def columns_of(trials: Iterable[Trial]) -> pa.Table:
    """Return trials in memory as a table of SCHEMA."""
    return pa.Table.from_pylist([asdict(trial) for trial in trials], SCHEMA)


def trials_in(trials: pa.Table) -> Iterator[Trial]:
    """Yield the trials of a table of SCHEMA, without the scores that are missing."""
    for one in trials.to_pylist():
        rows = [row | {"scores": {k: v for k, v in row["scores"].items() if v is not None}} for row in one["rows"]]
        yield Trial(one["point"], one["run"], tuple(TrialRow(**row) for row in rows))


def columns_in(lines: bytes) -> pa.Table:
    """Return the trials of whole lines of JSON as a table of SCHEMA; InputError for a line that is no trial."""
    if not lines:
        return SCHEMA.empty_table()
    options = arrow_json.ParseOptions(explicit_schema=SCHEMA, unexpected_field_behavior="ignore")
    whole = arrow_json.ReadOptions(use_threads=False, block_size=len(lines) + 1)  # a block must hold its longest line
    try:
        return arrow_json.read_json(pa.BufferReader(lines), whole, options)
    except pa.ArrowInvalid as error:
        what = f"a line is no trial: {str(error).splitlines()[0]}"
        raise InputError(what, do="choose another output directory, or remove this one") from None


def in_order(trials: pa.Table, runs: float = np.inf) -> pa.Table:
    """Return the trials of the runs below `runs`, sorted by point and run, the first of those with equal keys."""
    point, run = (trials.column(name).to_numpy() for name in ("point", "run"))
    order = np.lexsort((run, point))  # stable
    kept = run[order] < runs
    kept[1:] &= (np.diff(point[order]) != 0) | (np.diff(run[order]) != 0)
    return trials.take(order[kept])
