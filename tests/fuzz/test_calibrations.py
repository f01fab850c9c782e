"""Damaged calibrations, applied."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from calib import Calibration, from_json
from calib.external import MAX_CONDITION, checked
from calib.serial import KEYS
from recordings import write_recording
from recordings.assemble import recording_of
from tests.fuzz.contract import amounts, answered, fuzz, hold
from tests.fuzz.material import CALIBRATION, measured
from tests.fuzz.values import damaged_json

CASES, RESULTS = 160, 100


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """A directory with a log."""
    write_recording(recording_of(measured()), tmp_path / "log.parquet")
    return tmp_path


def check(place: Path, text: str) -> int:
    """Apply the calibration; returns the status."""
    out = place / "out"
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir()
    file = place / "calibration.json"
    file.write_text(text, encoding="utf-8", errors="surrogateescape")
    files = (str(file), str(place / "log.parquet"), "-o", str(out / "corrected.parquet"))
    status = hold(out, "apply", *files, "--no-page", "--json")
    assert [path.name for path in out.iterdir()] == ([] if status else ["corrected.parquet"])
    return status


@amounts
def test_calibrations(place: Path, times: int) -> None:
    fuzz(damaged_json(CALIBRATION), lambda text: check(place, text), CASES, times)


@amounts
def test_results_of_programs(times: int) -> None:
    """What a program wrote is refused in one line, or is a calibration of finite numbers that can be applied."""
    known = {key: value for key, value in CALIBRATION["ellipsoid"].items() if key in KEYS}

    def believed(text: str) -> None:
        found: list[Calibration] = []
        if answered(lambda: found.append(checked(from_json(text, where="result.json"), "result.json"))):
            assert np.isfinite([*found[0].offset_nT, *found[0].matrix.ravel()]).all()
            assert found[0].status.kind != "ok" or np.linalg.cond(found[0].matrix) <= MAX_CONDITION

    fuzz(damaged_json(known), believed, RESULTS, times)


def changed(**changes: object) -> str:
    return json.dumps({"ellipsoid": CALIBRATION["ellipsoid"] | changes})


@pytest.mark.parametrize(
    "text",
    [
        changed(matrix=[[1.0, 0.0, 0.0]] * 3),
        changed(matrix=[[0.0] * 3] * 3, eddy_s=None),
        changed(matrix=[[1e-300, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        changed(offset_nT=[1e300, 0.0, 0.0]),
        changed(eddy_s=[[1e300] * 3] * 3),
        changed(offset_nT=[float("nan"), 0.0, 0.0]),
        changed(segments=[{"start_s": 0.0, "offset_nT": [0.0] * 3, "matrix": [[0.0] * 3] * 3}]),
        changed(covariance=[[float("inf")] * 3] * 3),
        changed(wall_s=10**400),
        "[" * 100_000,
        "",
    ],
)
def test_known_cases(place: Path, text: str) -> None:
    assert check(place, text) == 2
