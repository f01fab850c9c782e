"""The assessment on the command line and in Python: verdict first, JSON keys, tolerance, arrays, odd logs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import magbench
from magbench.app import app
from recordings import Recording

CASES = Path(__file__).parents[1] / "recordings" / "cases"


def run(*words: str) -> str:
    result = CliRunner().invoke(app, ["calibrate", *words])
    assert result.exit_code == 0, result.output
    return result.stdout


def test_the_verdict_comes_first() -> None:
    text = run(str(CASES / "base.csv"), "--field-strength-nT", "48000")
    assert text.startswith("Heading within ")


def test_the_json_answers_for_each_calibration_and_the_tolerance() -> None:
    text = run(str(CASES / "base.csv"), "--field-strength-nT", "48000", "--tolerance-deg", "5", "--json")
    found = json.loads(text)
    one = found["calibrations"]["ellipsoid"]
    assert one["heading_error_deg"]["low"] < one["heading_error_deg"]["value"] < one["heading_error_deg"]["high"]
    assert one["strength_rms"]["after_held_out"] < one["strength_rms"]["before"]
    assert 0 < one["coverage"] <= 1
    assert found["tolerance"]["answer"] == "yes"
    assert found["use"] in ("offset", "offset and matrix")


def test_no_tolerance_is_refused_in_a_line() -> None:
    with pytest.raises(magbench.InputError, match="tolerance"):
        magbench.calibrate(CASES / "base.csv", 48_000.0, tolerance_deg=0.0)


@pytest.mark.parametrize("name", ["level_circle.csv", "level_2d.csv", "poses24.csv", "no_time.csv", "stuck_z.csv"])
def test_odd_logs_are_assessed(name: str) -> None:
    found = magbench.calibrate(CASES / name, 48_000.0, with_=[], tolerance_deg=3.0).assessment
    assert found.tolerance is not None
    assert found.tolerance.answer in ("yes", "no", "undecidable")
    assert all(one.heading is None or one.heading.low <= one.heading.high for one in found.calibrations.values())


def test_a_level_turn_is_trusted_as_such() -> None:
    found = magbench.calibrate(CASES / "level_circle.csv", 48_000.0, with_=[]).assessment
    assert found.recommended == "planar"
    assert found.trust.word in ("high", "medium")


def test_of_an_array_the_worst_sensor_counts() -> None:
    rng = np.random.default_rng(0)
    unit = rng.normal(size=(600, 3))
    unit *= 48_000.0 / np.linalg.norm(unit, axis=1)[:, None]
    array = np.stack([unit + rng.normal(0, noise, unit.shape) + 1000.0 for noise in (50.0, 400.0)])
    recording = Recording(np.arange(600.0) / 10.0, array[0], array_mag_nT=array)
    found = magbench.calibrate(recording, 48_000.0, with_=["ellipsoid"]).assessment
    assert set(found.calibrations) == {"ellipsoid@1", "ellipsoid@2"}
    assert found.recommended == "ellipsoid@2"
