"""Table of the trials of a comparison, a row for each calibrator and trial; bytes do not depend on the engine."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from numpy.typing import NDArray

from recordings.files import atomic_write, system_errors_about
from recordings.readers import verified_table
from scenarios.arrays import Array
from scenarios.errors import InputError
from scenarios.sweep import Value
from validation.comparison.design import Design
from validation.comparison.trial import Trial
from validation.comparison.trial_columns import COLUMNS, TIMES, WORDS, columns_of, in_order
from validation.scoring.definitions import score_definition
from validation.scoring.evaluation import UNCORRECTED

TRIALS, TIMINGS = "trials.parquet", "timings.parquet"
KINDS = {name: pa.int64() for name in ("point", "run", "seed")} | {
    name: pa.string() for name in ("calibrator", "status", "reason")
}
KEYS = tuple(KINDS)
WRITTEN = "give what `magbench compare` wrote"


@dataclass(frozen=True)
class TrialTable:
    """Trials as columns, sorted by point, run and calibrator in the order of the design.

    columns : `point`, a column for each swept key, `run`, `seed`, `calibrator`, `status`, `reason`, and the scores
    (float64, null where missing). times : `wall_s` and `cpu_s` (n,).
    """

    columns: pa.Table
    times: dict[str, Array]

    @classmethod
    def of(cls, design: Design, trials: Iterable[Trial]) -> TrialTable:
        """Build the table of trials in any order."""
        return cls.of_columns(design, in_order(columns_of(trials)))

    @classmethod
    def of_columns(cls, design: Design, trials: pa.Table) -> TrialTable:
        """Build the table of trials `in_order`, of `trial_columns.SCHEMA`."""
        width = len(design.calibrators)
        point, run = (np.repeat(trials.column(name).to_numpy(), width) for name in ("point", "run"))
        rows = trials.column("rows").combine_chunks().flatten()
        columns: dict[str, Any] = {"point": point}
        columns |= {key: _swept_column(design, key, point) for key in design.swept}
        columns |= {"run": run, "seed": np.full(len(run), design.seed)}
        columns["calibrator"] = list(design.calibrators) * len(trials)
        columns |= {name: rows.field(name) for name in WORDS}
        columns |= {name: values for name, values in _scores(rows) if len(values) > values.null_count}
        return cls(pa.table(columns), {name: rows.field(name).to_numpy() for name in TIMES})

    @classmethod
    def read(cls, path: Path) -> TrialTable:
        """Read the table of an output directory or a trials.parquet; times are empty without timings.parquet.

        Raises InputError for a damaged file, and for columns that no comparison writes.
        """
        file = path / TRIALS if path.is_dir() else path
        found = verified_table(file)
        _check(file, found, KINDS | {name: pa.float64() for name in COLUMNS if name in found.column_names})
        _check_rows(file, found)
        timings = file.with_name(TIMINGS)
        times = verified_table(timings, TIMES) if timings.exists() else pa.table({})
        _check(timings, times, {name: pa.float64() for name in times.column_names})
        return cls(found, {name: times.column(name).to_numpy() for name in times.column_names})

    def write(self, out: Path) -> None:
        """Write OUT/timings.parquet and OUT/trials.parquet; trials.parquet is equal on every machine."""
        keys = self.columns.select(["point", "run", "calibrator"])
        timings = keys
        for name, values in self.times.items():
            timings = timings.append_column(name, pa.array(values))
        for name, table in ((TIMINGS, timings), (TRIALS, self.columns)):
            with atomic_write(out / name) as part, system_errors_about(out / name):
                pq.write_table(table, part, compression="zstd", write_page_checksum=True)

    @cached_property
    def calibrators(self) -> tuple[str, ...]:
        """Row names in the order of the design, the raw measurement last."""
        return tuple(str(name) for name in self.columns.column("calibrator").unique().to_pylist())

    @property
    def candidates(self) -> tuple[str, ...]:
        """Row names of the calibrators, without the raw measurement."""
        return tuple(name for name in self.calibrators if name.split("@")[0] != UNCORRECTED)

    @property
    def scores(self) -> tuple[str, ...]:
        """Columns of scores present in any row."""
        return tuple(name for name in self.columns.column_names if name in COLUMNS)

    @property
    def swept(self) -> tuple[str, ...]:
        """Dotted keys of the swept values."""
        return tuple(name for name in self.columns.column_names if name not in KEYS and name not in COLUMNS)

    @cached_property
    def points(self) -> dict[int, dict[str, Value]]:
        """Swept values by number of the point."""
        numbers, first = np.unique(self._array("point"), return_index=True)
        held = {key: self.columns.column(key) for key in self.swept}
        rows = zip(numbers.tolist(), first.tolist(), strict=True)
        return {point: {key: values[row].as_py() for key, values in held.items()} for point, row in rows}

    def runs(self, point: int = 0) -> NDArray[np.int64]:
        """Return the run numbers (n,) of a point, ascending."""
        return np.unique(self._array("run")[self._array("point") == point])

    def values(self, score: str, calibrator: str, point: int = 0) -> Array:
        """Return a score (n,) of a calibrator at a point, by run, so values of two calibrators are paired.

        Missing scores are infinite. Raises InputError for an unknown score or calibrator.
        """
        name = score_definition(score).column
        rows = self._rows(calibrator, point)
        if name not in self.columns.column_names:
            return np.full(len(rows), np.inf)
        values: Array = self._array(name)[rows]
        return np.where(np.isnan(values), np.inf, values)

    def failed(self, calibrator: str, point: int = 0) -> NDArray[np.bool_]:
        """Return whether the status is not "ok" (n,), by run."""
        return np.asarray(self._array("status")[self._rows(calibrator, point)] != "ok", dtype=np.bool_)

    def texts(self, name: str, calibrator: str, point: int = 0) -> list[str]:
        """Return status or reason of a calibrator at a point, by run."""
        found: list[str] = self._array(name)[self._rows(calibrator, point)].tolist()
        return found

    def time_s(self, name: str, calibrator: str, point: int = 0) -> Array:
        """Return `wall_s` or `cpu_s` (n,) of the fits; NaN without timings."""
        rows = self._rows(calibrator, point)
        return self.times[name][rows] if name in self.times else np.full(len(rows), np.nan)

    def _rows(self, calibrator: str, point: int) -> NDArray[np.int64]:
        names = self.calibrators
        if calibrator not in names:
            raise InputError(f"no calibrator {calibrator!r} in the table", do=f"choose among {', '.join(names)}")
        # every trial has a row for each calibrator, in this order
        return self._first_rows(point) + names.index(calibrator)

    def _first_rows(self, point: int) -> NDArray[np.int64]:
        """Return the first row of every trial at a point."""
        if point not in self._starts:
            width = len(self.calibrators)
            self._starts[point] = np.flatnonzero(self._array("point")[::width] == point) * width
        return self._starts[point]

    @cached_property
    def _starts(self) -> dict[int, NDArray[np.int64]]:
        return {}

    def _array(self, name: str) -> NDArray[Any]:
        """Return a column as an array (n,): numbers with NaN for null, or text; converted once."""
        if name not in self._arrays:
            self._arrays[name] = self.columns.column(name).to_numpy()
        return self._arrays[name]

    @cached_property
    def _arrays(self) -> dict[str, NDArray[Any]]:
        return {}


def _check(file: Path, table: pa.Table, kinds: Mapping[str, pa.DataType]) -> None:
    """Raise InputError for a missing column, another type, a key without value, and a figure that is not finite."""
    for name, kind in kinds.items():
        if name not in table.column_names:
            raise InputError(f"there is no column {name}", where=str(file), do=WRITTEN)
        column = table.column(name)
        if column.type != kind or (name in KINDS and column.null_count):
            raise InputError(f"column {name} is no {kind} of every row", where=str(file), do=WRITTEN)
        if kind == pa.float64() and not np.isfinite(column.drop_null().to_numpy()).all():
            raise InputError(f"column {name} holds what is not finite", where=str(file), do=WRITTEN)


def _check_rows(file: Path, table: pa.Table) -> None:
    """Raise InputError unless every trial has a row for each calibrator, always in the same order."""
    names = table.column("calibrator").to_pylist()
    each = list(dict.fromkeys(names))
    trials = [table.column(key).to_numpy() for key in ("point", "run")]
    width = max(len(each), 1)
    if not names or names != each * (len(names) // width) or any((k[::width].repeat(width) != k).any() for k in trials):
        raise InputError("does not hold a row for each calibrator and trial", where=str(file), do=WRITTEN)
    if len(set(zip(*(key[::width].tolist() for key in trials), strict=True))) < len(names) // width:
        raise InputError("holds a trial twice", where=str(file), do=WRITTEN)


def _scores(rows: pa.StructArray) -> Iterator[tuple[str, pa.Array]]:
    """Yield name and values of every score; a value that is not finite becomes null."""
    for name, values in zip(COLUMNS, rows.field("scores").flatten(), strict=True):
        yield name, pc.if_else(pc.is_finite(values), values, None)


def _swept_column(design: Design, key: str, point: NDArray[np.int64]) -> pa.Array:
    """Return a swept value for every row: float64, or text where any value is text or boolean."""
    values = [one.values[key] for one in design.points]
    if any(isinstance(value, str | bool) for value in values):
        return pa.array([str(values[k]) for k in point])
    return pa.array(np.array(values, dtype=np.float64)[point])
