"""`magbench run --fail-if`: status 1 with one line, status 2 before anything is simulated."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from magbench.cli import main

RUN = ("run", "turntable-twelve-stops", "-o", "out", "--json")


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_a_score_beyond_its_limit_ends_with_status_1(capfd: pytest.CaptureFixture[str]) -> None:
    conditions = ("--fail-if", "ellipsoid.offset_error >= 0", "--fail-if", "de_turntable.offset_error < 0")
    assert main([*RUN, *conditions]) == 1
    told = capfd.readouterr()
    failures = json.loads(told.out)["failures"]
    assert len(failures) == 1
    assert told.err.splitlines()[-1] == f"magbench: {failures[0]}"


def test_a_score_within_its_limit_ends_with_status_0(capfd: pytest.CaptureFixture[str]) -> None:
    assert main([*RUN, "--fail-if", "ellipsoid.offset_error < 0"]) == 0
    assert json.loads(capfd.readouterr().out)["failures"] == []


@pytest.mark.parametrize("condition", ["nobody.heading_rms > 1", "ellipsoid.beauty > 1", "ellipsoid > 1"])
def test_unknown_names_are_refused_before_anything_is_simulated(
    condition: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert main([*RUN, "--fail-if", condition]) == 2
    assert capfd.readouterr().err.count("\n") == 1
    assert not Path("out").exists()


def test_a_calibrator_that_was_named_and_not_applicable_is_status_1(capfd: pytest.CaptureFixture[str]) -> None:
    rng = np.random.default_rng(0)
    field = rng.standard_normal((300, 3))
    field *= 48_000 / np.linalg.norm(field, axis=1, keepdims=True)
    rows = np.column_stack((0.1 * np.arange(300), field + np.array((100.0, -50.0, 20.0))))
    np.savetxt("log.csv", rows, delimiter=",", header="time_s,mag_x_nT,mag_y_nT,mag_z_nT", comments="")
    command = ["calibrate", "log.csv", "--field-strength-nT", "48000", "--with"]
    assert main([*command, "sphere,vector_least_squares"]) == 1
    assert "magbench: vector_least_squares was not applicable: " in capfd.readouterr().err
    assert main([*command, "sphere"]) == 0
