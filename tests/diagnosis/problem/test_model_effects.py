"""What a model's effects add is off where no attitude is compared, as it is where one is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.problem.formulation import pose
from diagnosis.problem.known import Known
from diagnosis.problem.linear import LinearProblem
from diagnosis.workflow import diagnose
from recordings import Recording
from sim.effects.base import Effect
from sim.effects.currents import MotorCurrent
from sim.effects.iron import HardIron, SoftIron
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import (
    FIELD_ENU_NT,
    NOISE_NT,
    STRENGTH_NT,
    recording,
    without_attitude,
)

CURRENT = MotorCurrent((30.0, -12.0, 45.0))
IRON = (SoftIron(((0.05, 0.02, 0.0), (0.01, -0.04, 0.0), (0.0, 0.03, 0.02))), HardIron((900.0, -600.0, 400.0)))
BELOW_DECK = {"motor_current": {"gain_nT_A": list(CURRENT.gain_nT_A)}}


def at_rest(current: bool) -> Recording:
    """A sensor that does not turn, with or without the current's field."""
    given = replace(without_attitude(recording()), gyro_rad_s=None)
    assert given.current_A is not None
    field_nT = np.random.default_rng(4).normal([900.0, 2e4, -4e4], NOISE_NT, (len(given), 3))
    added_nT = given.current_A.sum(axis=1, keepdims=True) * CURRENT.gain_nT_A
    return replace(given, mag_nT=field_nT + current * added_nT)


MOVING, AT_REST = without_attitude(recording(hidden=BELOW_DECK)), at_rest(current=True)


def left_nT(posed: LinearProblem) -> float:
    """Rms of what is compared."""
    return float(np.sqrt(((posed.target * posed.sigma_nT) ** 2).mean()))


def by_strength(given: Recording, *effects: Effect) -> LinearProblem:
    return pose(given, Known(None, STRENGTH_NT, effects))


@pytest.mark.parametrize("given", [MOVING, AT_REST])
def test_a_current_that_the_model_has_leaves_noise(given: Recording) -> None:
    assert left_nT(by_strength(given, CURRENT)) == pytest.approx(NOISE_NT, rel=0.05)
    assert left_nT(by_strength(given)) > 4 * NOISE_NT


def test_iron_is_fitted_in_place_of_the_models() -> None:
    given = without_attitude(recording(hidden=BELOW_DECK))
    with_iron, without = by_strength(given, *IRON, CURRENT), by_strength(given, CURRENT)
    assert left_nT(with_iron) == pytest.approx(left_nT(without), rel=0.02)
    np.testing.assert_allclose(with_iron.turn, np.eye(3), atol=1e-3)
    np.testing.assert_allclose(by_strength(given, *IRON).target, by_strength(given).target)


def test_an_effect_whose_cause_was_not_recorded_is_left_out() -> None:
    given = replace(without_attitude(recording()), current_A=None)
    posed = by_strength(given, CURRENT)
    np.testing.assert_allclose(posed.target, by_strength(given).target)
    assert posed.effects == (CURRENT,)


@pytest.mark.parametrize("given", [MOVING, AT_REST])
def test_what_the_models_effects_add_is_in_its_prediction_and_not_in_the_bases(given: Recording) -> None:
    """Else a hysteresis would see the motor's field, and take over what the motor's gain lacks."""
    posed = by_strength(given, CURRENT)
    added_nT = posed.predicted_nT - posed.clean_nT
    assert posed.recording.current_A is not None
    expected_nT = posed.recording.current_A.sum(axis=1, keepdims=True) * CURRENT.gain_nT_A
    np.testing.assert_allclose(added_nT, expected_nT)
    assert posed.still is (given is AT_REST)


@pytest.mark.parametrize("given", [MOVING, AT_REST])
def test_a_model_that_has_the_current_agrees_with_the_recording(given: Recording) -> None:
    tables = {**BELOW_DECK, "white_noise": {"std_nT": [NOISE_NT] * 3}}
    model = ModelSpec.model_validate({"effects": tables, "field": {"enu_nT": FIELD_ENU_NT.tolist()}})
    found = diagnose(given, model)
    assert (found.verdict, found.named) == ("none", ())
