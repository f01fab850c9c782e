"""A whole inspection: every section, one look a sensor, and a summary that JSON holds."""

from __future__ import annotations

import json
from itertools import groupby
from pathlib import Path

import numpy as np
import pytest

from scenarios.arrays import Array
from sim.dataset_writer import generate
from sim.scenario import load
from tests.validation.inspection.recordings import FIELD_ENU_NT, moved, noise, one
from validation.inspection.inspection import headline, inspect_file, summary

MOTION = moved(1500)
SECTIONS = ["file", "time", "values", "units", "frames", "motion", "calibration", "noise"]


def write(path: Path, **columns: Array) -> Path:
    table = np.column_stack(list(columns.values()))
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="", fmt="%.9g")
    return path


def field(name: str = "mag", offset_nT: float = 0.0) -> dict[str, Array]:
    mag_nT = MOTION.body(FIELD_ENU_NT) + offset_nT + noise(1500, 5.0)
    return {f"{name}_{axis}_nT": column for axis, column in zip("xyz", mag_nT.T, strict=True)}


def attitude() -> dict[str, Array]:
    return {f"att_q{axis}": column for axis, column in zip("wxyz", MOTION.q.T, strict=True)}


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("log") / "sound.csv", time_s=MOTION.time_s, **field(), **attitude())


def test_a_sound_log_has_nothing_to_mend(sound: Path) -> None:
    found = inspect_file(sound)
    assert found.warnings == []
    assert headline(found) == "sound.csv: no warning, nothing to mend."
    assert one(list(found.findings), "accepted").value is True


def test_of_a_dataset_it_is_told_which_run(tmp_path: Path) -> None:
    generate(load("tumble", ["sampling.rate_hz=2"]), tmp_path, runs=2)
    told = one(list(inspect_file(tmp_path, run=1).findings), "runs")
    assert (told.value, "this is run 1" in told.text) == (2, True)


def test_sections_follow_in_order(sound: Path) -> None:
    sections = [title for title, _ in groupby(finding.section for finding in inspect_file(sound).findings)]
    assert [section for section in SECTIONS if section in sections] == list(dict.fromkeys(sections))
    assert set(sections) == set(SECTIONS)


def test_the_summary_is_json(sound: Path) -> None:
    found = summary(inspect_file(sound))
    assert list(found) == ["file", "samples", "sensors", "warnings", "findings"]
    assert (found["samples"], found["sensors"], found["warnings"]) == (1500, 1, [])
    keys = {"section", "name", "value", "unit", "text", "level", "sensor"}
    assert all(set(finding) == keys for finding in found["findings"])
    json.dumps(found, allow_nan=False)


def test_each_sensor_of_an_array_has_findings_of_its_own(tmp_path: Path) -> None:
    path = write(tmp_path / "two.csv", time_s=MOTION.time_s, **field("mag1"), **field("mag2", 400.0))
    found = inspect_file(path)
    assert [data.sensor for data in found.sensors] == [1, 2]
    coverage = [finding.sensor for finding in found.findings if finding.name == "coverage"]
    assert coverage == [1, 2]
    assert summary(found)["sensors"] == 2


def test_a_file_that_is_refused_is_still_looked_at(tmp_path: Path) -> None:
    path = write(tmp_path / "uT.csv", time_s=MOTION.time_s, **{name: v / 1e3 for name, v in field().items()})
    found = inspect_file(path)
    accepted = one(list(found.findings), "accepted")
    assert accepted.level == "warning"
    assert "magbench calibrate` refuses the file" in accepted.text
    assert found.sensors[0].unit == "uT"
    assert headline(found).startswith("uT.csv: ")
    assert "warning" in headline(found)


def test_a_maps_unit_makes_it_sound(tmp_path: Path) -> None:
    path = write(tmp_path / "uT.csv", time_s=MOTION.time_s, **{name: v / 1e3 for name, v in field().items()})
    found = inspect_file(path, maps=[f"mag_{axis}_nT=mag_{axis}_nT,unit=uT" for axis in "xyz"])
    assert found.warnings == []
