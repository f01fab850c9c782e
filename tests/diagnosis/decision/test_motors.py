"""Several motors: a gain of each where their wires run differently, one gain where they do not; a throttle."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from diagnosis.decision.choice import AcceptedEffect, Selection, residual_tests
from diagnosis.decision.forms import split_by_motor
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import judge_candidate
from diagnosis.library.candidates import propose_candidates
from diagnosis.problem.sensors import with_actuators
from diagnosis.result import Diagnosis
from diagnosis.workflow import diagnose
from recordings import Recording
from sim.effects.kernels import first_order_lag
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import ALL_BUT_SEVEN, FIELD_ENU_NT, STRENGTH_NT, problem, recording, without_attitude

MODEL = ModelSpec.model_validate({"effects": {"white_noise": {"std_nT": [2.0] * 3}}})
UNEQUAL = np.array([[2.0, -1.0, 3.0], [-1.0, 2.0, 1.0], [3.0, 1.0, -2.0], [0.5, -2.0, 1.0]])
EQUAL = np.tile([2.0, -1.0, 3.0], (4, 1))


def driven(gains: np.ndarray, n: int = 1500) -> Recording:
    """A flight with four motors of these gains (4, 3)."""
    quiet = recording(n)
    t = quiet.time_s
    currents = [2 + np.sin((0.11 + 0.13 * k) * t + k) + 0.4 * np.sin((0.7 + 0.2 * k) * t) for k in range(4)]
    current_A = np.stack(currents, axis=1)
    return replace(quiet, mag_nT=quiet.mag_nT + current_A @ gains, current_A=current_A)


def told(given: Recording, **known: Any) -> Diagnosis:
    return diagnose(given, MODEL, **{"field_enu_nT": FIELD_ENU_NT, "without": ALL_BUT_SEVEN, **known})


def gains_of(found: Diagnosis) -> dict[int, tuple[float, ...]]:
    (one,) = found.named
    assert one.name == "motor_current"
    return {effect.motor: effect.gain_nT_A for effect in one.effects}  # type: ignore[attr-defined]


@pytest.mark.parametrize("attitude", [True, False])
def test_motors_whose_wires_run_differently_have_a_gain_each_and_one_name(attitude: bool) -> None:
    given = driven(2 * UNEQUAL)
    if attitude:
        found = told(given)
    else:
        found = diagnose(
            without_attitude(given), MODEL, strength_nT=STRENGTH_NT, fitted_base=True, without=ALL_BUT_SEVEN
        )
    assert found.verdict == "named"
    for motor, gain in gains_of(found).items():
        assert gain == pytest.approx(2 * UNEQUAL[motor - 1], abs=0.5)
    assert len(gains_of(found)) == 4
    assert len(found.model.effects["motor_current"]) == 4


@pytest.mark.parametrize(("gains", "first"), [(2 * UNEQUAL, 4), (EQUAL, 1)])
def test_motors_that_were_found_first_are_asked_again_beside_a_second_effect(gains: np.ndarray, first: int) -> None:
    start = Baseline.of(problem(driven(gains)))
    found = [
        judge_candidate(start, propose_candidates(start.problem)[name])
        for name in ("motor_current", "temperature_offset")
    ]
    accepted = tuple(AcceptedEffect(one, ()) for one in found if one is not None)
    tests = residual_tests(start, ())
    split = split_by_motor(Selection(accepted, start, start, tests, tests, (), frozenset()))
    assert [one.name for one in split.accepted] == [*first * ["motor_current"], "temperature_offset"]


def test_motors_of_one_gain_have_one() -> None:
    assert list(gains_of(told(driven(EQUAL)))) == [0]


def test_motors_of_one_gain_have_one_beside_a_wander_too() -> None:
    given = driven(EQUAL)
    walk_nT = np.cumsum(np.random.default_rng(3).normal(scale=0.5, size=given.mag_nT.shape), axis=0)
    found = diagnose(
        replace(given, mag_nT=given.mag_nT + walk_nT), MODEL, field_enu_nT=FIELD_ENU_NT, without=ALL_BUT_SEVEN
    )
    (one,) = (one for one in found.named if one.name == "motor_current")
    assert [effect.motor for effect in one.effects] == [0]  # type: ignore[attr-defined]


def test_a_motor_that_does_nothing_beside_the_others_is_left_out() -> None:
    some = UNEQUAL * np.array([[1.0], [1.0], [1.0], [0.0]])
    assert set(gains_of(told(driven(some)))) == {1, 2, 3}


def test_a_throttle_is_ahead_of_the_current_and_its_unit_does_not_matter() -> None:
    quiet = recording(1500)
    throttle = np.repeat(np.random.default_rng(4).uniform(0, 1, 38), 40)[:1500]
    current_A = first_order_lag(throttle[:, None], 1.2, 0.1, {})
    given = replace(quiet, mag_nT=quiet.mag_nT + current_A * [8.0, -5.0, 12.0], channels={"throttle": 1e-3 * throttle})
    given = with_actuators(replace(given, current_A=None), ["throttle"], Path("log"))
    found = told(given)
    (one,) = found.named
    assert (found.verdict, one.name) == ("named", "motor_current")
    assert one.effect.lag_s == pytest.approx(1.2, rel=0.1)  # type: ignore[attr-defined]
    assert one.effect.gain_nT_A == pytest.approx((8e3, -5e3, 12e3), rel=0.05)  # type: ignore[attr-defined]


def test_of_motors_that_run_alike_one_gain_is_told() -> None:
    """Whatever each of them has of it: of one course nobody knows the parts."""
    one = driven(UNEQUAL)
    assert one.current_A is not None
    quiet, course_A = recording(1500), one.current_A[:, :1]
    alike = replace(
        quiet, mag_nT=quiet.mag_nT + course_A * UNEQUAL.sum(axis=0), current_A=np.repeat(course_A, 4, axis=1)
    )
    (gain,) = gains_of(told(alike)).values()
    assert gain == pytest.approx(UNEQUAL.mean(axis=0), abs=0.1)
