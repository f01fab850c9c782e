"""Others' libraries open a dataset by its folder: every run once, with one schema, and the phase as words."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.dataset
import pyarrow.parquet
import pytest

import magbench
from recordings import read_manifest
from sim.dataset_writer import generate
from tests.short import short

Rows = dict[int, int]
"""Number of a run -> its samples."""


def by_pandas(out: Path) -> Rows:
    frame = pd.read_parquet(out / "data")
    assert set(frame["phase"]) == {"tumble"}
    return dict(frame.groupby("run").size())


def by_arrow(out: Path) -> Rows:
    table = pa.dataset.dataset(out / "data").to_table(columns=["run"])
    return {row["values"]: row["counts"] for row in table["run"].value_counts().to_pylist()}


def by_polars(out: Path) -> Rows:
    polars = pytest.importorskip("polars", reason="polars is not installed")
    assert polars.read_parquet(out / "data")["phase"].unique().to_list() == ["tumble"]
    counts = polars.scan_parquet(out / "data").group_by("run").len().collect()
    return dict(counts.iter_rows())


def by_duckdb(out: Path) -> Rows:
    duckdb = pytest.importorskip("duckdb", reason="duckdb is not installed")
    query = f"select run, count(*) from '{out}/data/**/*.parquet' where phase = 'tumble' group by run"
    return dict(duckdb.sql(query).fetchall())


def by_datasets(out: Path) -> Rows:
    parts = loaded(out)
    assert parts["test"].features["phase"].dtype == "string"
    assert set(parts["test"]["phase"]) == {"tumble"}
    runs = np.concatenate([np.asarray(part["run"]) for part in parts.values()])
    return dict(zip(*np.unique(runs, return_counts=True), strict=True))


def loaded(out: Path, name: str | None = None) -> dict[str, object]:  # type: ignore[type-arg]
    datasets = pytest.importorskip("datasets", reason="Hugging Face datasets is not installed")
    return dict(datasets.load_dataset(str(out), name, cache_dir=str(out.parent / "cache")))


@pytest.fixture(autouse=True)
def without_a_network(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")


@pytest.mark.parametrize("read", [by_pandas, by_arrow, by_polars, by_duckdb, by_datasets], ids=lambda f: f.__name__)
def test_the_folder_opens_as_a_whole(read: Callable[[Path], Rows], dataset: Path) -> None:
    assert read(dataset) == {file.run: file.rows for file in read_manifest(dataset).files}


def test_hugging_face_finds_the_parts_and_the_table_of_runs(dataset: Path) -> None:
    rows = {part: len(held) for part, held in loaded(dataset).items()}  # type: ignore[arg-type]
    manifest = read_manifest(dataset)
    split = manifest.split
    assert split is not None
    assert rows == {part: sum(file.rows for file in manifest.files if split.part_of(file.run) == part) for part in rows}
    assert set(rows) == {"train", "validation", "test"}
    assert len(loaded(dataset, "runs")["runs"]) == manifest.runs  # type: ignore[arg-type]


def test_a_part_without_a_run_is_not_promised(tmp_path: Path) -> None:
    generate(short("tumble"), tmp_path / "one", split="100/0/0")
    assert set(loaded(tmp_path / "one")) == {"train"}


def test_all_files_have_one_schema(dataset: Path) -> None:
    schemas = [pa.parquet.read_schema(path) for path in (dataset / "data").rglob("*.parquet")]
    assert all(one.remove_metadata().equals(schemas[0].remove_metadata(), check_metadata=True) for one in schemas)


def test_a_run_of_a_frame_that_holds_many_is_a_recording(dataset: Path) -> None:
    frame = pd.read_parquet(dataset / "data" / "train")
    for run, rows in list(frame.groupby("run"))[:2]:
        found = magbench.calibrate(rows, 50_000, with_="ellipsoid")
        alone = magbench.calibrate(dataset, 50_000, with_="ellipsoid", run=int(run))
        np.testing.assert_array_equal(found.offset_nT, alone.offset_nT)


def test_a_plain_dataset_opens_beside_its_manifest_as_the_page_says(tmp_path: Path) -> None:
    generate(short("tumble"), tmp_path / "plain", runs=2)
    total = sum(file.rows for file in read_manifest(tmp_path / "plain").files)
    assert len(pd.read_parquet(tmp_path / "plain", ignore_prefixes=["dataset.json"])) == total
    whole = pa.dataset.dataset(tmp_path / "plain", format="parquet", exclude_invalid_files=True)
    assert whole.count_rows() == total
    polars = pytest.importorskip("polars", reason="polars is not installed")
    assert len(polars.read_parquet(tmp_path / "plain" / "*.parquet")) == total
