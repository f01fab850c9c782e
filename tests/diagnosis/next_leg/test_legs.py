"""The measured motion of a leg, and the problem that it poses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.next_leg import legs
from diagnosis.next_leg.legs import CandidateLeg, legs_of, measured_along
from scenarios.errors import InputError
from sim.effects.currents import MotorCurrent
from sim.scenario import load
from tests.diagnosis.synthetic import problem, recording

SHORT = load("auv-spiral", ["phases.0.duration_s=45", "navigation.attitude_noise_std_deg=1"])
LEG = CandidateLeg("a short spiral", SHORT)


def test_a_leg_is_flown_without_any_error() -> None:
    """Of sensor or navigation: the strength of the field is the same all along, and the attitude is smooth."""
    flown = measured_along(SHORT)
    strength_nT = np.linalg.norm(flown.mag_nT, axis=1)
    assert np.ptp(strength_nT) < 1e-6 * strength_nT.mean()
    assert flown.att_q is not None
    assert np.abs(np.diff(flown.att_q, n=3, axis=0)).max() < 1e-4


def test_a_leg_poses_a_problem_with_what_acts_always_in_the_noise_in_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    like = replace(problem(n=300), sigma_nT=np.array([1.0, 2.0, 7.0]))
    along, always = recording(400), MotorCurrent(gain_nT_A=(30.0, -20.0, 10.0))
    monkeypatch.setattr(legs, "measured_along", lambda scenario: along)
    with_it, without = (LEG.problem(like, some) for some in ((always,), ()))
    assert with_it is not None
    assert without is not None
    assert with_it.sigma_nT.tolist() == [1.0, 2.0, 7.0]
    added_nT = with_it.recording.mag_nT - without.recording.mag_nT
    assert added_nT == pytest.approx(along.current_A.sum(axis=1)[:, None] * np.array([30.0, -20.0, 10.0]))  # type: ignore[union-attr]


def test_a_leg_that_the_vehicle_does_not_end_poses_none(monkeypatch: pytest.MonkeyPatch) -> None:
    def stuck(scenario: object) -> None:
        raise InputError("the vehicle does not come to the end")

    monkeypatch.setattr(legs, "measured_along", stuck)
    assert LEG.problem(problem(n=300), ()) is None


def test_a_vehicle_is_offered_what_it_can_fly_and_as_often_as_needed() -> None:
    words = [leg.words for leg in legs_of(SHORT)]
    assert "a comb" in words
    assert "stops on the way round" not in words
    assert LEG.repeated(3).phases == SHORT.phases * 3
