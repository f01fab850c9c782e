"""The Croissant metadata: valid for mlcroissant, which reads the same samples by it."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from recordings import read_manifest

RECOMMENDED = {"citeAs", "datePublished"}
"""What only a dataset that was published has."""


def test_every_column_of_every_part_is_a_field_with_its_unit(dataset: Path) -> None:
    told = json.loads((dataset / "croissant.json").read_text())
    sets = {one["@id"]: one["field"] for one in told["recordSet"]}
    assert set(sets) == {"samples-train", "samples-validation", "samples-test", "runs"}
    names = [column.name for column in read_manifest(dataset).columns]
    assert [field["source"]["extract"]["column"] for field in sets["samples-test"]] == names
    by_name = {field["source"]["extract"]["column"]: field for field in sets["samples-test"]}
    assert by_name["gyro_x_rad_s"]["description"] == "measured body rate, body frame: x (rad/s)"
    assert by_name["phase"]["dataType"] == "sc:Text"
    assert by_name["run"]["dataType"] == "sc:Integer"


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_mlcroissant_finds_it_valid_and_reads_the_same_samples(dataset: Path) -> None:
    croissant = pytest.importorskip("mlcroissant", reason="mlcroissant is not installed")
    found = croissant.Dataset(str(dataset / "croissant.json"))
    issues = found.metadata.ctx.issues
    assert not issues.errors
    assert {warning.split('"')[1].rsplit("/")[-1] for warning in issues.warnings} <= RECOMMENDED
    (file,) = [file for file in read_manifest(dataset).files if "/test/" in file.path]
    rows = pq.read_table(dataset / file.path, partitioning=None).to_pylist()
    for record, row in itertools.islice(zip(found.records("samples-test"), rows, strict=True), 20):
        assert record["samples-test/mag_x_nT"] == row["mag_x_nT"]
        assert record["samples-test/run"] == row["run"] == file.run
    runs = pq.read_table(dataset / "runs.parquet").to_pylist()
    key = "effects.hard_iron.offset_nT.2"
    assert [record[f"runs/{key}"] for record in found.records("runs")] == [row[key] for row in runs]
