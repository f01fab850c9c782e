"""The standard case with the Kalman filter by filterpy beside its compiled twin, as `--with` names them."""

from __future__ import annotations

import pytest

from sim.scenario import load
from validation.calibrating.selection import select_calibrators
from validation.comparison.design import Design
from validation.comparison.engine import SerialEngine, run_trials

TWINS = ("kalman_rescaled", "kalman_rescaled:engine=filterpy")


def test_filterpy_s_row_of_the_standard_case_is_that_of_the_compiled_twin() -> None:
    scenario = load("standard-full", ["phases.0.duration_s=60"])
    (trial,) = run_trials(Design.of(scenario, select_calibrators(TWINS)), range(1), SerialEngine())
    compiled, filterpy = (next(row for row in trial.rows if row.calibrator == name) for name in TWINS)
    assert compiled.status == filterpy.status
    assert compiled.scores["offset_error_nT"] > 0.0
    for name, value in compiled.scores.items():
        assert filterpy.scores[name] == pytest.approx(value, rel=1e-5), name
