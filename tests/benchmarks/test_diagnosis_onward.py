"""The bench of the advised leg: what is drawn, what counts as a class of two, and as told apart."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.diagnosis.onward import ALIKE, DRAWN, HIDDEN, SIZES, Trial, drawn, report
from sim.effects import BY_NAME


def row(names: list[list[str]], then: list[list[str]], hidden: str = "motor_current") -> dict[str, Any]:
    told = {"name": names[0][0], "other": names[0][-1], "leg": "a comb", "nats": 9.0}
    return {"key": "one", "hidden": hidden, "names": names, "then": then} | told


@pytest.mark.parametrize("motion", DRAWN)
def test_a_drawn_motion_is_a_scenario_of_some_minutes_at_few_samples(motion: str) -> None:
    name = next(hidden for one, hidden in ALIKE if one == motion)
    models = [Trial(motion, name, seed).model for seed in range(8)]
    assert len({str(model.phases) for model in models}) > 1
    assert all(sum(phase.duration_s for phase in model.phases) < 900 for model in models)
    assert all(model.sampling.rate_hz <= 10 for model in models)


def test_what_is_hidden_has_the_drawn_size() -> None:
    for trial in drawn(0, 60):
        assert SIZES[0] <= trial.size <= SIZES[1]
        plain = HIDDEN[trial.hidden](np.random.default_rng([trial.seed, 5]))
        (name, *_) = (*BY_NAME[trial.effect].linear, "angles_deg")
        np.testing.assert_allclose(trial.table[name], trial.size * np.array(plain[name]))


def test_a_twin_makes_no_class_of_two_larger() -> None:
    twins = row([["hard_iron", "sensor_offset", "motor_current"]], [["motor_current"]])
    three = row([["hard_iron", "hard_iron_drift", "motor_current"]], [["motor_current"]])
    assert "2 with a leg for a class that holds the truth, 1 of two" in report([twins, three])


def test_a_leg_tells_apart_where_it_leaves_the_truth_without_the_other() -> None:
    pair = [["soft_iron", "eddy_current"]]
    for then, apart in (([["eddy_current"]], 1), ([["eddy_current", "soft_iron"]], 0), ([["soft_iron"]], 0), ([], 0)):
        assert f"told apart by the leg: {apart} of 1, {apart} of 1" in report([row(pair, then, "eddy_current")])
