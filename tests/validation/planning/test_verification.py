"""The check of a plan by trials: rms over those that succeed, and a failure for each other."""

from __future__ import annotations

import pytest

from sim.scenario import load
from validation.bound.goal import Goal
from validation.comparison.engine import SerialEngine
from validation.comparison.trial import Trial, TrialRow
from validation.planning import verification


def test_a_failed_trial_counts_as_failed_and_not_in_the_error(monkeypatch: pytest.MonkeyPatch) -> None:
    told = [("ok", {"offset_error_nT": 3.0}), ("ok", {"offset_error_nT": 4.0}), ("ok", {}), ("not_converged", {})]
    told.append(("unobservable", {"offset_error_nT": 1e6}))  # taken back, though there is an estimate
    rows = [TrialRow("ellipsoid", status, "", scores, 0.0, 0.0) for status, scores in told]
    raw = TrialRow("uncorrected", "ok", "", {"offset_error_nT": 1e5}, 0.0, 0.0)
    monkeypatch.setattr(
        verification, "run_trials", lambda design, runs, engine: [Trial(0, k, (rows[k], raw)) for k in runs]
    )
    scenario = load("tumble").model_copy(update={"calibrators": ("ellipsoid",)})
    found = verification.confirmed(scenario, Goal("offset", "offset_error", "nT"), len(rows), SerialEngine())
    assert found.error == pytest.approx((12.5) ** 0.5)
    assert (found.calibrator, found.trials, found.failures) == ("ellipsoid", 5, 3)
