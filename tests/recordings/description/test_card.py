"""The dataset card says what is in the folder."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from recordings import read_manifest
from recordings.description.card import SIZES


def test_front_matter_names_the_files_of_every_part(dataset: Path) -> None:
    yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")
    _, front, _ = (dataset / "README.md").read_text().split("---\n", 2)
    told = yaml.safe_load(front)
    assert told["license"] == "apache-2.0"
    samples, runs = told["configs"]
    assert samples["default"] is True
    for part in samples["data_files"]:
        assert part["path"] == f"data/{part['split']}/*.parquet"
        assert list(dataset.glob(part["path"]))
    assert [part["path"] for part in runs["data_files"]] == ["runs.parquet"]
    rows = sum(file.rows for file in read_manifest(dataset).files)
    assert 1000 <= rows < 10_000
    assert told["size_categories"] == [SIZES[1]] == ["1K<n<10K"]


def test_the_card_tells_columns_parts_and_what_varies(dataset: Path) -> None:
    text, manifest = (dataset / "README.md").read_text(), read_manifest(dataset)
    for column in manifest.columns:
        assert re.search(rf"^\| `{column.name}` \| \w+ \| {re.escape(column.unit)} \| ", text, re.MULTILINE)
    assert manifest.split is not None
    for part, runs in manifest.split.counts(manifest.runs).items():
        rows = sum(file.rows for file in manifest.files if f"/{part}/" in file.path)
        assert f"| {part} | {runs} | {rows} |" in text
    assert all(f"| `{key}` |" in text for key in manifest.scenario["vary"])
    assert not [line for line in text.splitlines() if "{{" in line or "{%" in line]
