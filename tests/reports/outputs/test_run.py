"""What `run` says in JSON: every score and calibration, and nothing that JSON cannot hold."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

from calib import from_json
from recordings import read_run
from reports.outputs.run import calibrate_and_score, summary
from sim.dataset_writer import generate
from sim.memory_run import run_in_memory
from sim.scenario import load
from sim.simulation import plan
from tests.reports import outcome_example as example
from validation.bound.bound import Bound
from validation.bound.files import run_experiment
from validation.bound.sensor_noise import stated_noise_nT
from validation.calibrating.selection import select_calibrators
from validation.scoring.outcome import RANKED_BY, Outcome
from validation.scoring.scores import Score

NEITHER = {"in_sample": False, "rotation_removed": False, "bound_ratio": None}


@pytest.fixture(scope="module")
def outcome() -> Outcome:
    whole: Outcome = example.example_outcome(300)
    lost = [Score("offset_error", float("nan"), "nT"), Score("heading_rms", float("inf"), "deg")]
    return dataclasses.replace(whole, scores=whole.scores | {"psoga": lost})


def test_scores_are_rows_with_their_unit_and_null_for_what_is_not_finite(outcome: Outcome) -> None:
    found = json.loads(json.dumps(summary(outcome), allow_nan=False))
    assert list(found) == ["scenario", "answer", "ranking", "tracking", "scores", "calibrations"]
    assert found["answer"]["use"] == outcome.ranking()[0][0]
    assert [one["calibrator"] for one in found["answer"]["failed"]] == ["psoga", "gyro_ml"]
    assert found["answer"]["compare"].startswith("magbench compare SCENARIO.toml")
    assert found["scores"]["psoga"] == [
        {"score": "offset_error", "value": None, "unit": "nT"} | NEITHER,
        {"score": "heading_rms", "value": None, "unit": "deg"} | NEITHER,
    ]
    assert found["ranking"] == outcome.ranking()[0]
    assert found["tracking"] is None


def test_calibrations_are_read_back(outcome: Outcome) -> None:
    found = summary(outcome)["calibrations"]
    back = from_json(json.dumps(found["ellipsoid"]), name="ellipsoid", where="summary")
    np.testing.assert_allclose(back.offset_nT, outcome.calibrations["ellipsoid"].offset_nT)


def test_a_run_is_judged_against_its_own_truth(tmp_path_factory: pytest.TempPathFactory) -> None:
    """A calibrator that knows the field to its noise is close to the truth; progress only grows."""
    scenario = load("tumble", ["sampling.rate_hz=5"])
    folder = tmp_path_factory.mktemp("run") / "data"
    generate(scenario, folder)
    told: list[float] = []
    found = calibrate_and_score(scenario, *read_run(folder), told.append)
    assert list(found.calibrations) == list(scenario.calibrators)
    assert told == sorted(told)
    assert 0 <= told[0] < told[-1] <= 1
    best = found.ranking()[0][0]
    error = next(s.value for s in found.scores[best] if s.name == RANKED_BY)
    assert error < 0.002 * found.field_strength_nT


def test_scores_of_a_run_are_ratios_to_its_bound(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Three components of one run: their rms over the bound's is between 0.15 and 2.3 in 99 of 100."""
    scenario = load("standard-full", ["phases.0.duration_s=120"])
    folder = tmp_path_factory.mktemp("ratio") / "data"
    generate(scenario, folder)
    rows = summary(calibrate_and_score(scenario, *read_run(folder)))["scores"]
    ratio = {key: {one["score"]: one["bound_ratio"] for one in some} for key, some in rows.items()}
    for name in ("ellipsoid", "vector_least_squares"):
        assert 0.15 < ratio[name]["offset_error"] < 2.3
        assert ratio[name]["wall_time"] is None
    assert ratio["sphere"]["offset_error"] > 5
    assert set(ratio["uncorrected"].values()) == {None}


def test_who_finds_eddy_currents_too_is_held_against_what_they_cost() -> None:
    """Turns of a quadrotor tell less of the offset where they may be eddy currents: the bound is 3.5 times as wide."""
    scenario = load("quad-comb")
    run = plan(scenario)
    outcome = calibrate_and_score(
        scenario, *run_in_memory(run), chosen=select_calibrators(["vector_least_squares", "vector_lm"])
    )
    known = run_experiment(run, stated_noise_nT(run.effects[0]))
    assert Bound.of(known, "vector+eddy").offset_rms_nT > 3 * Bound.of(known, "vector").offset_rms_nT
    for name, knowledge in (("vector_least_squares", "vector"), ("vector_lm", "vector+eddy")):
        ratio = next(one["bound_ratio"] for one in summary(outcome)["scores"][name] if one["score"] == "offset_error")
        error = next(one.value for one in outcome.scores[name] if one.name == "offset_error")
        assert error / ratio == pytest.approx(Bound.of(known, knowledge).offset_rms_nT, rel=1e-6)
