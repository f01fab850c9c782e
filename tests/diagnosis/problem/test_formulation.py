"""Whitening, the fitted turn and the noise of a problem, in vector and in strength mode."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from diagnosis.policy import STANDARD
from diagnosis.problem.formulation import pose, pose_again, pose_model
from diagnosis.problem.known import FieldTrack, Known, ReferenceCorrection
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.motion import quieter_rate
from diagnosis.repair.refinement import chain_residual
from scenarios.errors import InputError
from sim.effects.base import Effect
from sim.effects.currents import MotorCurrent
from sim.effects.earth import RegionalField
from sim.effects.iron import HardIron, SoftIron
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import (
    FIELD_ENU_NT,
    NOISE_NT,
    STRENGTH_NT,
    problem,
    recording,
    without_attitude,
)

ERROR_RAD = np.radians(0.02)
MATRIX = np.array([[1.05, 0.01, -0.02], [0.0, 0.97, 0.015], [0.005, 0.01, 1.02]])


def test_the_noise_of_a_sample_is_that_of_the_sensor() -> None:
    assert problem().sigma_nT == pytest.approx([NOISE_NT] * 3, rel=0.06)
    assert problem(without_attitude(recording())).sigma_nT == pytest.approx([NOISE_NT], rel=0.06)


def test_the_fitted_turn_is_the_matrix_that_was_applied() -> None:
    given = recording(noise_nT=0.1)
    moved = replace(given, mag_nT=given.mag_nT @ MATRIX.T + np.array([300.0, -200.0, 100.0]))
    assert problem(moved).turn == pytest.approx(MATRIX, abs=1e-4)


def test_an_error_of_the_given_field_does_not_bend_the_turn() -> None:
    """Of 600 nT across the field, with iron: the matrix is the applied one, and the base is still off."""
    given = recording(noise_nT=0.1)
    R_wb = problem(given).state.R_wb
    error_nT = np.array([500.0, 0.0, 0.0]) - FIELD_ENU_NT * (500.0 * FIELD_ENU_NT[0] / STRENGTH_NT**2)
    seen = given.mag_nT + np.einsum("nji,j->ni", R_wb, error_nT)
    posed = problem(replace(given, mag_nT=seen @ MATRIX.T + np.array([300.0, -200.0, 100.0])))
    assert posed.turn == pytest.approx(MATRIX, abs=1e-4)
    assert np.sqrt((posed.target**2).mean()) > 100


def test_where_the_motion_shows_no_error_of_the_field_the_turn_is_that_of_the_base() -> None:
    """On level circles such an error is a soft iron: the prior holds it at zero."""
    given = recording()
    turn = Rotation.from_euler("Z", 0.13 * given.time_s[:, None])
    mag_nT = turn.inv().apply(FIELD_ENU_NT) + np.random.default_rng(0).normal(scale=NOISE_NT, size=(len(given), 3))
    level = replace(given, mag_nT=mag_nT, att_q=turn.as_quat()[:, [3, 0, 1, 2]])
    assert problem(level).turn[:2, :2] == pytest.approx(np.eye(2), abs=1e-4)


@pytest.fixture(scope="module")
def level_circles() -> LinearProblem:
    """With an attitude that errs by 0.02 degrees, which the model does not state, and the sensor's own matrix."""
    n, rng = 12_000, np.random.default_rng(0)
    t = np.arange(n) / 10
    error = lfilter([np.sqrt(1 - 0.998**2)], [1, -0.998], ERROR_RAD * rng.normal(size=(n, 3)), axis=0)
    tilt = np.radians(0.005) * np.sin(0.3 * t)
    turn = Rotation.from_euler("ZYX", np.column_stack([np.radians(t), tilt, tilt]))
    given = replace(
        recording(n),
        mag_nT=turn.inv().apply(FIELD_ENU_NT) @ MATRIX.T + 10.0 * rng.normal(size=(n, 3)),
        att_q=(Rotation.from_rotvec(error) * turn).as_quat()[:, [3, 0, 1, 2]],
    )
    return problem(given, (SoftIron(tuple(map(tuple, MATRIX - np.eye(3)))),))


@pytest.mark.parametrize("stated", [True, False])
def test_an_error_of_the_attitude_that_is_stated_does_not_bend_the_turn(
    level_circles: LinearProblem, stated: bool
) -> None:
    """On level circles the field varies along the vertical by less than the attitude's error turns it."""
    posed = pose_again(level_circles, attitude_std_rad=ERROR_RAD * stated)
    off = np.abs(posed.turn - MATRIX).max()
    assert off < 0.06 if stated else off > 0.3


def test_what_a_model_states_and_what_was_done_hold_where_a_problem_is_posed_anew(
    level_circles: LinearProblem,
) -> None:
    gone = np.arange(len(level_circles.recording)) < 100
    first, second = (ReferenceCorrection(words, "", FIELD_ENU_NT) for words in ("first", "second"))
    stated = pose_again(level_circles, attitude_std_rad=ERROR_RAD, corrections=(first,)).without(gone)
    anew = pose_again(stated, corrections=(*stated.corrections, second))
    assert np.abs(anew.turn - MATRIX).max() < 0.06
    assert (anew.usable == ~gone).all()
    assert anew.corrections == (first, second)


def test_a_fixed_turn_of_the_sensor_leaves_no_gap() -> None:
    given = recording()
    turned = replace(given, mag_nT=Rotation.from_euler("ZYX", [1.0, 0.4, -0.2]).apply(given.mag_nT))
    left = problem(turned).target
    assert np.sqrt((left**2).mean()) == pytest.approx(1.0, abs=0.05)


def test_the_earths_field_passes_through_the_turn_and_what_is_behind_the_iron_does_not() -> None:
    given = recording(noise_nT=0.1)
    posed = problem(replace(given, mag_nT=given.mag_nT @ MATRIX.T))
    e = np.random.default_rng(0).normal(size=(len(given), 3, 2))
    assert posed.whitened(e, RegionalField) * posed.sigma_nT[:, None] == pytest.approx(posed.turn @ e)
    assert posed.whitened(e, MotorCurrent) * posed.sigma_nT[:, None] == pytest.approx(e)


def test_along_a_track_a_problem_is_posed_anew_with_its_field() -> None:
    given = recording(300)
    change = np.linspace(-3000.0, 3000.0, 300)[:, None] * [0.2, 1.0, 0.7]
    before = replace(problem(given), track=FieldTrack(FIELD_ENU_NT, change))
    anew = pose_again(before, given_enu_nT=FIELD_ENU_NT)
    strength_nT = np.linalg.norm(FIELD_ENU_NT + change, axis=1)
    assert np.linalg.norm(anew.state.field_nT, axis=1) == pytest.approx(strength_nT)


def test_ahead_of_the_iron_a_change_along_the_field_is_seen_whole_and_a_turn_not_at_all() -> None:
    given = recording(noise_nT=0.1)
    along = given.mag_nT / np.linalg.norm(given.mag_nT, axis=1, keepdims=True)
    posed = problem(replace(given, mag_nT=given.mag_nT @ MATRIX.T))
    changes = along, np.cross(along, [0.3, -0.7, 0.6])
    for change, seen in zip(changes, (1.0, 0.0), strict=True):
        assert (posed.field_projection * (change @ MATRIX.T)).sum(axis=1) == pytest.approx(seen, abs=1e-3)


def test_samples_left_out_weigh_nothing() -> None:
    posed = problem()
    gone = np.zeros(len(posed.recording), bool)
    gone[100:200] = True
    rest = posed.without(gone)
    for values in (rest.target, rest.base, rest.whitened(np.ones((len(gone), 3, 1)), RegionalField)):
        assert not values[gone].any()
        assert values[~gone].any()


@pytest.mark.parametrize("effect", [RegionalField, MotorCurrent], ids=lambda one: one.name)
def test_the_column_of_a_strength_is_its_derivative(effect: type[Effect]) -> None:
    """``d|h| / d eps`` of the calibrated field, by a difference."""
    given = recording(noise_nT=0.1)
    posed = problem(without_attitude(replace(given, mag_nT=given.mag_nT @ MATRIX.T)))
    e = np.random.default_rng(1).normal(size=(len(given), 3))
    inward = e if effect is RegionalField else e @ np.linalg.inv(posed.turn).T
    h, small = posed.state.field_nT, 1e-2
    change = np.linalg.norm(h + small * inward, axis=1) - np.linalg.norm(h - small * inward, axis=1)
    column = posed.whitened(e[:, :, None], effect)[:, 0, 0]
    assert column * posed.sigma_nT == pytest.approx(change / (2 * small), abs=1e-6)


def test_the_strengths_base_takes_up_every_small_change_of_iron() -> None:
    posed = problem(without_attitude(recording(noise_nT=1e-3)))
    for changed in (HardIron((5.0, -3.0, 4.0)), SoftIron(((1e-4, 2e-5, 0), (2e-5, -1e-4, 0), (0, 0, 5e-5)))):
        done = changed.apply(posed.state, posed.state.field_nT, np.random.default_rng(0), {})
        column = posed.whitened(done[:, :, None], RegionalField)[:, 0, 0]
        left = column - posed.base @ np.linalg.lstsq(posed.base, column, rcond=None)[0]
        assert np.linalg.norm(left) < 1e-6 * np.linalg.norm(column)


def test_a_few_wrong_samples_do_not_move_the_base_and_many_are_a_gap() -> None:
    given = recording()
    for share, moved in ((0.01, False), (0.3, True)):
        mag = given.mag_nT.copy()
        mag[np.random.default_rng(2).random(len(mag)) < share] += 5000.0
        offset = (problem(replace(given, mag_nT=mag)).clean_nT - given.mag_nT).mean(axis=0)
        assert (np.abs(offset).max() > 100.0) == moved


def test_longer_than_any_moment_is_refused_with_what_it_may_be() -> None:
    given = recording()
    with pytest.raises(InputError, match=r"lasts 4628 d, and at most 116 d.*unit=us"):
        problem(replace(given, time_s=1e6 * given.time_s))


def test_an_attitude_that_is_held_gives_way_to_the_gyro() -> None:
    given = recording()
    truth = quieter_rate(given, STANDARD)
    noisy = truth + 0.05 * np.random.default_rng(3).normal(size=truth.shape)
    assert given.att_q is not None
    held = np.repeat(given.att_q[::2], 2, axis=0)
    assert (quieter_rate(replace(given, gyro_rad_s=noisy), STANDARD) == truth).all()
    assert (quieter_rate(replace(given, gyro_rad_s=noisy, att_q=held), STANDARD) == noisy).all()


def test_a_recording_too_short_to_cut_is_refused() -> None:
    with pytest.raises(InputError, match="at least 200"):
        pose(recording(100), Known(FIELD_ENU_NT, STRENGTH_NT))


def test_iron_that_is_not_known_is_fitted_in_the_place_of_the_models() -> None:
    tables = {"hard_iron": {"offset_nT": [500.0, -300.0, 200.0]}, "white_noise": {"std_nT": [NOISE_NT] * 3}}
    model = ModelSpec.model_validate({"effects": tables, "field": {"enu_nT": FIELD_ENU_NT.tolist()}})
    off = {
        known: chain_residual(pose_model(recording(), model, None, None, iron_known=known), ())
        for known in (True, False)
    }
    assert np.sqrt((off[False] ** 2).mean()) == pytest.approx(1.0, rel=0.05)
    assert np.sqrt((off[True] ** 2).mean()) > 100
