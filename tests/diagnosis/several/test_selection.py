"""The setting of a candidate that several recordings choose together, and what the search for the setting costs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.evidence.held_out import search_price
from diagnosis.library.candidates import Candidate
from diagnosis.policy import STANDARD
from diagnosis.several.pooled_test import PooledCandidate, cross_predicted
from sim.effects.currents import CurrentRipple, MotorCurrent
from tests.diagnosis.synthetic import problem, recording

GIVEN = [
    problem(recording(1200, seed=seed, hidden={"motor_current": {"gain_nT_A": [3.0, -2.0, 4.0]}})) for seed in (1, 2)
]
BASELINES = [ColouredBaseline.of(one, []) for one in GIVEN]
MOTOR = Candidate(MotorCurrent)
ONE, OTHER = MOTOR.at({"motor": 1}), MOTOR.at({"motor": 2})
"""The field of one motor alone: in part that of all."""
GONE = MOTOR.at({"motor": 9})


def test_the_setting_of_the_largest_joint_gain_is_tested_whichever_is_given() -> None:
    """All motors together, as hidden, rather than one of them."""
    for given in (MOTOR, ONE):
        rest = [one for one in (ONE, MOTOR, OTHER) if one != given]
        found = PooledCandidate.best([given, *rest], BASELINES, GIVEN)
        assert found.candidate == MOTOR
    alone = PooledCandidate.best([ONE], BASELINES, GIVEN)
    assert alone.candidate == ONE
    assert alone.gain < found.gain


def test_a_search_costs_by_all_that_were_tried_at_every_setting() -> None:
    searched = [replace(one, tried=200) for one in (MOTOR, ONE)]
    found = PooledCandidate.best(searched, BASELINES, GIVEN)
    assert found.price == search_price(400, 3, STANDARD) > search_price(200, 3, STANDARD)


def test_what_no_recording_holds_is_the_least_likely() -> None:
    noise_models = [one.hypothesis.noise_model for one in BASELINES]
    likely = cross_predicted([MOTOR, GONE, ONE], GIVEN, BASELINES, noise_models)
    assert likely[GONE] == -np.inf
    assert likely[MOTOR] > likely[ONE] > 0.0
    nowhere = PooledCandidate.best([GONE, GONE], BASELINES, GIVEN)
    assert (nowhere.here, nowhere.width) == ({}, 0)


def test_one_recording_without_the_cause_leaves_the_choice_to_the_others() -> None:
    off = {name: 0.0 * values for name, values in GIVEN[1].state.channels.items()}
    still = replace(GIVEN[1], state=replace(GIVEN[1].state, channels=off))
    problems = [GIVEN[0], still, GIVEN[1]]
    baselines = [BASELINES[0], ColouredBaseline.of(still, []), BASELINES[1]]
    found = PooledCandidate.best([ONE, MOTOR], baselines, problems)
    assert found.candidate == MOTOR
    assert [one is None for one in found.in_recordings] == [False, True, False]


@pytest.mark.parametrize("kind", [MotorCurrent, CurrentRipple])
def test_a_pool_has_the_width_and_the_policy_of_its_recordings(kind: type[MotorCurrent] | type[CurrentRipple]) -> None:
    candidate = MOTOR if kind is MotorCurrent else Candidate.of(CurrentRipple(frequency_hz=1.3))
    found = PooledCandidate.best([candidate], BASELINES, GIVEN)
    assert found.width == candidate.columns(GIVEN[0]).shape[2]
    assert found.policy is GIVEN[0].policy
    assert found.scale_error == 0.0
