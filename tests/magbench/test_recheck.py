"""`magbench.recheck` and its command: old calibrations of several programs against a new log."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import magbench
from magbench.cli import main
from recordings import write_recording
from recordings.applied import AppliedCalibration
from recordings.recording import Origin
from scenarios.errors import InputError
from tests.validation.rechecking.test_recheck import EXACT, FIELD_ENU_NT, OFFSET_NT, STRENGTH, log
from validation.calibrating.calibration_file import write_calibrations

FIELD = ["--field-enu-nT", ",".join(map(str, FIELD_ENU_NT))]
MOVED_NT = OFFSET_NT + np.array([0.0, -933.0, 0.0])


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """The same calibration in every form, the log of an unchanged instrument, and of one with stale iron."""
    write_calibrations({"ellipsoid": EXACT}, tmp_path, ["c", "px4", "ardupilot", "ros"])
    write_recording(log(0), tmp_path / "same.parquet")
    write_recording(log(1, MOVED_NT), tmp_path / "moved.parquet")
    return tmp_path


@pytest.mark.parametrize(
    "old", ["calibration.json", "mag_calibration.h", "px4.params", "ardupilot.param", "magnetometer.yaml"]
)
def test_every_form_of_the_old_calibration_gives_the_same_answer(
    place: Path, old: str, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, status, verdict in (("same", 0, "valid"), ("moved", 1, "changed")):
        assert main(["recheck", str(place / old), str(place / f"{name}.parquet"), *FIELD, "--json"]) == status
        told = json.loads(capsys.readouterr().out)
        assert told["verdict"] == verdict
    assert told["changes"][0]["what"] == "offset"
    assert told["changes"][0]["value"][1] == pytest.approx(-933.0, abs=40.0)
    assert told["heading_error_deg"]["low"] > 2.5


def test_the_terminal_says_the_verdict_first(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["recheck", str(place / "calibration.json"), str(place / "moved.parquet"), *FIELD]) == 1
    assert capsys.readouterr().out.startswith("changed: offset by (")


def test_the_calibration_in_force_in_the_log_can_be_asked_for() -> None:
    applied = AppliedCalibration("px4", 0, EXACT.offset_nT, EXACT.matrix)
    native = replace(log(1, MOVED_NT), origin=Origin(applied=applied))
    found = magbench.recheck("applied", native, field_enu_nT=FIELD_ENU_NT)
    assert found.verdict == "changed"
    assert repr(found).startswith("changed")
    with pytest.raises(InputError, match="no calibration in force"):
        magbench.recheck("applied", log(1), STRENGTH.strength_nT)


def test_a_log_in_counts_is_judged_by_a_calibration_in_counts(place: Path) -> None:
    counts = replace(log(0, MOVED_NT), mag_nT=np.round(log(0, MOVED_NT).mag_nT / 10), origin=Origin(unit="count"))
    (place / "dump.txt").write_text("set mag_calibration = 50,-30,20\n")
    found = magbench.recheck(place / "dump.txt", counts)
    assert found.unit == "counts"
    assert found.verdict == "changed"


def test_calibrate_prints_the_figures_of_other_programs(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["calibrate", str(place / "same.parquet"), *FIELD, "--with", "ellipsoid", "--others"]
    assert main(arguments) == 0
    assert "fitness" in capsys.readouterr().out
    assert main([*arguments, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["known_figures"]["ellipsoid"]
    assert {one["program"] for one in told} == {"ArduPilot", "MAGFit", "Betaflight", "MotionCal", "NXP"}
    (fitness,) = [one for one in told if one["name"] == "fitness"]
    assert fitness["value"] == pytest.approx(0.5, abs=0.1)  # white noise of 50 nT
    assert fitness["passes"]


@pytest.mark.parametrize(("name", "verdict", "status"), [("moved", "changed", 1), ("same", "valid", 0)])
def test_diagnose_tells_stale_iron_of_a_stated_calibration(
    place: Path, name: str, verdict: str, status: int, capsys: pytest.CaptureFixture[str]
) -> None:
    """First in the terminal, in the page, and with its size in the file and in Python."""
    data, old, out = str(place / f"{name}.parquet"), str(place / "px4.params"), place / "out"
    assert main(["diagnose", data, "--model", old, *FIELD, "-o", str(out)]) == status
    first = f"the stated calibration, {name}: {verdict}: "
    assert " ".join(capsys.readouterr().out.split()).startswith(first)
    assert first in (out / "report.html").read_text()
    (iron,) = json.loads((out / "diagnosis.json").read_text())["stated_calibration"]
    assert iron["verdict"] == verdict
    found = magbench.diagnose(data, old, field_enu_nT=FIELD_ENU_NT)
    assert [one.answer.verdict for one in found.stated] == [verdict]
    if verdict == "changed":
        assert iron["changed"][0]["effect"] == "hard_iron"
        assert iron["changed"][0]["low"][1] < -933.0 < iron["changed"][0]["high"][1]


def test_two_logs_with_different_iron_each_tell_theirs(place: Path) -> None:
    logs = [place / "same.parquet", place / "moved.parquet"]
    found = magbench.diagnose(logs, place / "calibration.json", field_enu_nT=FIELD_ENU_NT)
    told = found.presented.summary["stated_calibration"]
    assert [(one["recording"], one["verdict"]) for one in told] == [("same", "valid"), ("moved", "changed")]


def test_a_result_has_a_table_and_a_picture(place: Path) -> None:
    found = magbench.recheck(place / "calibration.json", place / "same.parquet", field_enu_nT=FIELD_ENU_NT)
    assert list(found.to_frame()["part"]) == [one.what for one in found.parts]
    assert found.plot().axes


@pytest.mark.parametrize(
    ("options", "what"),
    [
        (["--compass", "7"], "choose among ellipsoid"),
        (["--tolerance-deg", "-1"], "no tolerance"),
        (["--old-unit", "furlong"], "is no unit"),
        (["--sensor", "2"], "there is no sensor 2"),
    ],
)
def test_wrong_use_is_one_line(place: Path, options: list[str], what: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["recheck", str(place / "calibration.json"), str(place / "same.parquet"), *FIELD, *options]) == 2
    assert what in capsys.readouterr().err
