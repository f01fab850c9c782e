"""JSON of `magbench simulate`, and the manifest dataset.json."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from reports.schemas.base import ResultTable, TrackingJson, key, where_told


class RunFileJson(ResultTable):
    """A file of the dataset."""

    run: int = key("number of the run, or of the first in the file")
    path: str = key("path in the dataset's directory")
    rows: int = key("samples")
    bytes: int = key("size of the file")
    sha256: str = key("SHA-256 of the file")
    tracking: TrackingJson | None = key("how well the path was followed; null for a vehicle that follows none")


class ColumnJson(ResultTable):
    """A column of the files."""

    name: str = key("name, unit included")
    unit: str = key("unit; 1 for pure numbers, empty for text")
    meaning: str = key("what the column holds")
    group: str = key("recording, truth, effect and so on")


class SplitJson(ResultTable):
    """Shares of the runs for a learner."""

    train: int = key("per cent for training")
    validation: int = key("per cent for validation")
    test: int = key("per cent for the test")
    seed: int = key("seed of the order in which the runs are dealt out")


class DatasetJson(ResultTable):
    """The manifest of a dataset: equal commands and installations write equal bytes."""

    schema_: int = Field(alias="schema", description="version of the format")
    complete: bool = key("whether every run is there; false after an interruption")
    seed: int = key("seed of the dataset; the seed of a run follows from it and the run's number")
    runs: int = key("number of runs")
    packages: dict[str, str] = key("versions of the packages that affect the data")
    scenario: dict[str, Any] = key("the whole scenario, as `magbench schema scenario` describes")
    files: list[RunFileJson] = key("the files")
    columns: list[ColumnJson] = key("the columns of every file")
    split: SplitJson | None = where_told("shares of train, validation and test; only in a split dataset")
    runs_per_file: int | None = where_told("runs that share a file; only where more than one does")


class SimulateJson(ResultTable):
    """What `simulate` has written."""

    out: str = key("directory or URL of the dataset")
    runs: int = key("number of runs")
    seed: int = key("seed of the dataset")
    split: dict[str, int] | None = where_told("number of runs of train, validation and test; only with --split")
    samples: int = key("samples of all files")
    tracking: TrackingJson | None = key("of all runs together")
    files: list[RunFileJson] = key("the files")
