"""A log whose attitude comes late, made by turning at other times: a matter of time stamps, and no effect."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from diagnosis.decision.second_passes import (
    attitude_in_time,
    best_lead_s,
    gyro_agrees,
    is_late,
    lead_gap_nT,
    without_attitude,
)
from diagnosis.evidence.baseline import Baseline
from diagnosis.library.candidates import Candidate
from diagnosis.policy import STANDARD
from diagnosis.problem.formulation import pose
from diagnosis.problem.known import FieldTrack, Known
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.motion import attitude_course
from diagnosis.result import Diagnosis
from diagnosis.verdict import Verdict
from diagnosis.workflow import diagnose
from recordings import Recording
from scenarios.arrays import Array
from sim.effects.currents import EddyCurrent, MotorCurrent
from sim.effects.dynamics import Latency
from sim.effects.parameters import ACTIVE_WINDOW
from sim.rotation import cross, matrix_from_q, multiply_q, q_from_rotation_vector, to_body
from sim.scenario import ModelSpec
from tests.nightly import first_daily

FIELD_ENU_NT = np.array([1400.0, 18700.0, -45800.0])
TIME_S = np.arange(0.0, 150.0, 0.04)
NOISE_NT = 40.0
OFFSET_NT = np.array([300.0, -200.0, 500.0])
UNEVEN_S = 0.01 * np.array([[4.0, 1.0, -1.0], [0.0, 1.0, 1.0], [1.0, 0.0, 2.5]])


def hand_q(time_s: Array) -> Array:
    """A hand that turns about three axes, as quaternions (n, 4)."""
    angles = np.stack([0.7 * np.sin(1.1 * time_s), 0.6 * np.sin(1.7 * time_s + 1), 1.5 * np.sin(0.6 * time_s)], axis=1)
    x, y, z = (q_from_rotation_vector(angles[:, [axis]] * np.eye(3)[axis]) for axis in range(3))
    return np.ascontiguousarray(multiply_q(z, multiply_q(y, x)))


def field_at(time_s: Array) -> Array:
    """The field (n, 3) that the hand's sensor is in."""
    return to_body(matrix_from_q(hand_q(time_s)), FIELD_ENU_NT[None])


def posed(mag_nT: Array, att_q: Array) -> LinearProblem:
    return pose(Recording(time_s=TIME_S, mag_nT=mag_nT, att_q=att_q), Known(FIELD_ENU_NT, 5e4))


def course_of(problem: LinearProblem) -> CubicSpline:
    return attitude_course(problem.recording.time_s, np.asarray(problem.recording.att_q))


def found(mag_nT: Array, attitude_late_s: float = 0.0) -> Diagnosis:
    noise = NOISE_NT * np.random.default_rng(1).normal(size=mag_nT.shape)
    attitude = hand_q(TIME_S - attitude_late_s)
    log = Recording(time_s=TIME_S, mag_nT=mag_nT + OFFSET_NT + noise, att_q=attitude)
    return diagnose(log, ModelSpec(), field_enu_nT=FIELD_ENU_NT, fitted_base=True)


@pytest.mark.parametrize("late_s", first_daily([0.015, 0.09]))
def test_a_late_attitude_is_moved_to_its_time_and_nothing_is_missing(late_s: float) -> None:
    told = found(field_at(TIME_S), late_s)
    assert told.verdict is Verdict.NONE
    assert told.sentence.startswith(f"The attitude comes {1e3 * late_s:.0f}")
    assert "earlier the gap falls from" in told.advice[0]


def test_an_attitude_whose_lateness_varies_is_moved_by_its_mean() -> None:
    """What that leaves comes and goes with the turns, so that no name may be found for it."""
    late_s = 0.06 * (1 + 0.3 * np.random.default_rng(2).uniform(-1, 1, size=len(TIME_S)))
    start = Baseline.of(posed(field_at(TIME_S), hand_q(TIME_S - late_s)))
    selection: Any = SimpleNamespace(start=start, accepted=())
    ((_, moved),) = attitude_in_time(selection)
    assert moved.corrections[0].words.startswith("The attitude comes 60")


def test_the_lead_leaves_no_delay_of_its_own() -> None:
    """In a hand some microseconds show beside little noise."""
    problem = posed(field_at(TIME_S) + OFFSET_NT, hand_q(TIME_S - 0.0307))
    assert best_lead_s(problem, course_of(problem), 0.03) == pytest.approx(0.0307, abs=3e-6)


def test_rows_of_an_unknown_attitude_are_not_reached_into() -> None:
    """The last rows of a slower attitude stand, and are left out."""
    problem = posed(field_at(TIME_S), hand_q(TIME_S)).without(np.arange(len(TIME_S)) >= len(TIME_S) - 5)
    assert np.flatnonzero(without_attitude(problem, 0.1)).tolist() == list(range(len(TIME_S) - 8, len(TIME_S)))


def test_what_follows_a_pause_is_not_known_ahead_of_it() -> None:
    """Moved to its time, an attitude just ahead of a pause would be one from within the pause."""
    given, late_s = field_at(TIME_S), 0.09
    there = (np.abs(TIME_S - 60.0) > 4.0) & (np.abs(TIME_S - 110.0) > 3.0)
    noise = NOISE_NT * np.random.default_rng(1).normal(size=given.shape)
    log = Recording(
        time_s=TIME_S[there], mag_nT=(given + OFFSET_NT + noise)[there], att_q=hand_q(TIME_S - late_s)[there]
    )
    told = diagnose(log, ModelSpec(), field_enu_nT=FIELD_ENU_NT, fitted_base=True)
    assert (told.verdict, told.named) == (Verdict.NONE, ())
    assert told.sentence.startswith("The attitude comes 90")


def test_the_lead_is_sought_in_the_field_along_the_track() -> None:
    change = np.linspace(-3000.0, 3000.0, len(TIME_S))[:, None] * [0.2, 1.0, 0.7]
    mag_nT = to_body(matrix_from_q(hand_q(TIME_S)), FIELD_ENU_NT + change)
    track = FieldTrack(FIELD_ENU_NT, change)
    problem = replace(posed(mag_nT, hand_q(TIME_S - 0.05)), track=track)
    assert lead_gap_nT(problem, course_of(problem), 0.05) < 1.0


def test_samples_that_are_no_measurements_do_not_count_for_the_lead() -> None:
    wrong = np.arange(len(TIME_S)) % 7 == 0
    problem = posed(field_at(TIME_S) + 1e4 * wrong[:, None], hand_q(TIME_S - 0.05)).without(wrong)
    assert lead_gap_nT(problem, course_of(problem), 0.05) < 1.0


def _selection(clean: bool, *accepted: tuple[Candidate, float, list[str]]) -> Any:
    problem = SimpleNamespace(turns=True, policy=STANDARD, sigma_nT=np.full(3, NOISE_NT))
    effects = [
        SimpleNamespace(
            name=candidate.name,
            alternatives=alike,
            evidence=SimpleNamespace(strength=strength, candidate=candidate),
        )
        for candidate, strength, alike in accepted
    ]
    return SimpleNamespace(start=SimpleNamespace(problem=problem), after=SimpleNamespace(clean=clean), accepted=effects)


DELAY = Candidate(Latency, (("delay_s", 0.1),))
FREE, IN_A_PART = Candidate(EddyCurrent), Candidate(EddyCurrent).at({ACTIVE_WINDOW.name: (20.0, 50.0)})


@pytest.mark.parametrize(
    ("named", "again", "strength", "clean", "late"),
    [
        (FREE, FREE, 0.1, True, False),
        (FREE, DELAY, 0.1, True, False),
        (FREE, Candidate(MotorCurrent), 0.1, True, True),
        (FREE, FREE, 0.1, False, True),
        (FREE, FREE, 4.0, False, False),
        (DELAY, FREE, 4.0, False, True),
        (IN_A_PART, FREE, 4.0, False, True),
    ],
)
def test_an_attitude_is_late_where_no_name_for_it_is_left(
    named: Candidate, again: Candidate, strength: float, clean: bool, late: bool
) -> None:
    """Nor may what is found beside it be that name; where the lead varies, a small part of it is what that leaves.

    A delay, or an effect in a part of the run, is not free to be ahead of the field.
    """
    selection, other = (
        _selection(clean, (named, 10.0, [])),
        _selection(clean, (again, strength, ["eddy_current"] * (again is DELAY))),
    )
    assert is_late(selection, other) is late


def test_a_late_magnetometer_stays_a_delay() -> None:
    told = found(field_at(TIME_S - 0.05))
    assert told.problem.corrections == ()
    assert told.named[0].name == "latency"


def test_uneven_eddy_currents_stay_what_they_are() -> None:
    field_nT = field_at(TIME_S)
    rate = np.gradient(field_nT, TIME_S, axis=0)
    told = found(field_nT + rate @ UNEVEN_S.T)
    assert told.problem.corrections == ()
    assert told.named[0].name == "eddy_current"


def test_far_less_than_an_interval_is_no_matter_of_time_stamps() -> None:
    field_nT = field_at(TIME_S)
    told = found(field_nT + 0.006 * np.gradient(field_nT, TIME_S, axis=0))
    assert told.problem.corrections == ()
    assert told.named[0].name == "eddy_current"


def test_time_stamps_are_asked_of_an_attitude_alone() -> None:
    """Without one the field's rate is the measurement's own."""
    noise = NOISE_NT * np.random.default_rng(1).normal(size=(len(TIME_S), 3))
    rate = -cross(np.full((len(TIME_S), 3), 0.4), field_at(TIME_S))
    log = Recording(time_s=TIME_S, mag_nT=field_at(TIME_S) + 0.03 * rate + noise)
    assert diagnose(log, ModelSpec(), field_enu_nT=FIELD_ENU_NT, fitted_base=True).problem.corrections == ()


@pytest.mark.parametrize(("late_s", "agrees"), [(0.12, True), (0.16, True), (0.3, False), (0.0, False)])
def test_a_gyro_says_by_how_much_an_attitude_is_late(late_s: float, agrees: bool) -> None:
    """The field is asked for a lead of 0.12 s; the gyro's rate is that of the true turn, the attitude's is late."""
    turn = Rotation.from_quat(hand_q(TIME_S), scalar_first=True)
    gyro_rad_s = np.zeros((len(TIME_S), 3))
    gyro_rad_s[1:-1] = (turn[:-2].inv() * turn[2:]).as_rotvec() / (TIME_S[2] - TIME_S[0])
    log = Recording(TIME_S, field_at(TIME_S), gyro_rad_s=gyro_rad_s, att_q=hand_q(TIME_S - late_s))
    assert gyro_agrees(pose(log, Known(FIELD_ENU_NT, 5e4)), 0.12) is agrees
    assert not gyro_agrees(posed(field_at(TIME_S), hand_q(TIME_S - 0.12)), 0.12)
