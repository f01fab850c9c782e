"""A trial is what `run` would give: the same recording, fits and scores; and what has no estimate has no scores."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calib import Calibration, Status
from recordings import read_run
from reports.outputs.run import calibrate_and_score
from scenarios.errors import InputError
from sim.dataset_writer import generate
from tests.short import short
from validation.calibrating.selection import select_calibrators
from validation.comparison.design import Design, received
from validation.comparison.trial import PendingTrial, TrialRow, compute, failed_trial, run_trial
from validation.scoring.definitions import SCORE_DEFINITIONS
from validation.scoring.evaluation import UNCORRECTED


def test_a_trial_is_the_run_of_that_number_judged_from_its_files(tmp_path: Path) -> None:
    scenario = short("turntable-twelve-stops")
    names = ("vector_least_squares", "ellipsoid", "tolles_lawson")
    generate(scenario, tmp_path, runs=3, seed=9)
    outcome = calibrate_and_score(scenario, *read_run(tmp_path, run=2), chosen=select_calibrators(names))
    trial = run_trial(Design.of(scenario, select_calibrators(names), seed=9), 0, 2)
    assert [row.calibrator for row in trial.rows] == [*names, UNCORRECTED] == list(outcome.scores)
    for row in trial.rows:
        scores = {SCORE_DEFINITIONS[one.name].column: one.value for one in outcome.scores[row.calibrator]}
        kept = {name: value for name, value in scores.items() if name not in ("failure", "wall_time_s")}
        fitted = outcome.calibrations.get(row.calibrator)
        assert row.scores == (kept if fitted is None or fitted.has_estimate else {})
    assert trial.rows[2].status == "not_applicable"
    assert trial.rows[2].reason


def test_every_sensor_of_an_array_has_its_row() -> None:
    design = Design.of(short("gradiometer-turntable"), select_calibrators(["sphere"]))
    trial = run_trial(design, 0, 0)
    assert tuple(row.calibrator for row in trial.rows) == design.calibrators
    assert design.calibrators[-1] == f"{UNCORRECTED}@4"
    errors_nT = {row.scores["offset_error_nT"] for row in trial.rows}
    assert len(errors_nT) == len(trial.rows)


def test_a_task_gives_the_trial(design: Design) -> None:
    def told(task: PendingTrial) -> list[tuple[object, ...]]:
        return [(row.calibrator, row.status, row.scores) for row in compute(task).rows]

    there = [(row.calibrator, row.status, row.scores) for row in run_trial(design, 1, 3).rows]
    assert told(pickle.loads(pickle.dumps(PendingTrial(design.sent, 1, 3)))) == there


def test_points_share_their_noise(design: Design) -> None:
    """Paired: the same errors at every point, and noise that differs in size alone."""
    quiet, loud = (run_trial(design, point, 0).rows[-1] for point in (0, 1))
    assert quiet.scores["offset_error_nT"] == pytest.approx(loud.scores["offset_error_nT"])
    assert quiet.scores["in_sample_norm_rms_nT"] != loud.scores["in_sample_norm_rms_nT"]


def test_a_lost_trial_is_failed_for_all(design: Design) -> None:
    rows = failed_trial(design, 0, 4, "why").rows
    assert list(rows) == [TrialRow(name, "not_converged", "why", {}, 0.0, 0.0) for name in design.calibrators]


def test_an_estimate_is_what_is_not_the_raw_measurement() -> None:
    for kind, there in (("ok", True), ("not_converged", False), ("unobservable", False), ("not_applicable", False)):
        raw = Calibration(name="a", status=Status(kind))  # type: ignore[arg-type]
        assert raw.has_estimate == there
        moved = replace(raw, offset_nT=np.array([1.0, 0.0, 0.0]))
        assert moved.has_estimate == (kind != "not_applicable")


def test_a_worker_with_other_versions_refuses(design: Design) -> None:
    other = replace(design, packages={**design.packages, "numpy": "0.1"})
    with pytest.raises(InputError, match=r"numpy 0\.1 there"):
        received(other.sent)


@pytest.mark.parametrize("names", [["sphere", "sphere"], [UNCORRECTED], []])
def test_a_design_has_one_calibrator_of_a_name(names: list[str]) -> None:
    (sphere,) = select_calibrators(["sphere"])
    with pytest.raises(InputError, match="--with"):
        Design.of(short("tumble"), [replace(sphere, name=name) for name in names])
