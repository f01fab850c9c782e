"""A field that was misread, and a heading that was made from the magnetometer that is examined."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from diagnosis.evidence.reference_checks import _own_east_nT, correct_reference, find_misread_field, find_own_compass
from diagnosis.policy import STANDARD
from diagnosis.problem.formulation import pose, pose_model
from diagnosis.problem.known import Known
from diagnosis.verdict import Verdict
from diagnosis.workflow import diagnose
from recordings import Recording, read_recording
from scenarios.arrays import Array
from sim.scenario import ModelSpec
from tests.diagnosis.own_compass import IRON, with_own_compass
from tests.diagnosis.synthetic import COSTLY, FIELD_ENU_NT, NOISE_NT, STRENGTH_NT, problem, recording

EAST, NORTH, UP = FIELD_ENU_NT
GAPS = {
    "nothing": {},
    "a vertical wave": {"diurnal_drift": {"amplitude_enu_nT": [0.0, 0.0, 60.0], "period_s": 200.0}},
    "a current": {"motor_current": {"gain_nT_A": [30.0, -10.0, 20.0]}},
}


@pytest.mark.parametrize(
    ("given", "how"), [((EAST, NORTH, -UP), "the other sign"), ((NORTH, EAST, -UP), "north, east, down")]
)
def test_a_misread_field_is_told_and_read_right(given: tuple[float, float, float], how: str) -> None:
    wrong = pose(recording(), Known(np.array(given), STRENGTH_NT))
    found = find_misread_field(wrong)
    assert found is not None
    assert how in found.words
    assert found.field_enu_nT == pytest.approx(FIELD_ENU_NT)
    before_nT, after_nT = map(float, re.findall(r"from ([\d.]+) to ([\d.]+) nT", found.figures)[0])
    assert after_nT == pytest.approx(NOISE_NT, rel=0.05)
    assert before_nT > 1000 * NOISE_NT
    mended = correct_reference(wrong)
    assert mended.state.field_enu_nT == pytest.approx(FIELD_ENU_NT)
    assert mended.sigma_nT == pytest.approx(NOISE_NT, rel=0.1)
    assert how in mended.corrections[0].words


def test_an_effect_is_named_beside_a_misread_field_and_the_model_has_the_right_one() -> None:
    hidden = {"motor_current": {"gain_nT_A": [3.0, -1.0, 2.0]}}
    found = diagnose(
        recording(hidden=hidden),
        ModelSpec.model_validate({"field": {"enu_nT": (EAST, NORTH, -UP)}}),
        fitted_base=True,
        without=COSTLY,
    )
    assert found.verdict is Verdict.NAMED
    assert [one.name for one in found.named] == ["motor_current"]
    assert "the other sign" in found.sentence
    assert found.model.field.enu_nT == pytest.approx(FIELD_ENU_NT)


@pytest.mark.parametrize("hidden", GAPS.values(), ids=GAPS)
def test_neither_is_said_of_a_log_whose_reference_is_right(hidden: dict[str, object]) -> None:
    right = problem(hidden=hidden)
    assert find_misread_field(right) is None
    assert find_own_compass(right) is None


def _level_circles() -> Recording:
    given = recording()
    turn = Rotation.from_euler("Z", 0.13 * given.time_s[:, None])
    noise = np.random.default_rng(0).normal(scale=NOISE_NT, size=(len(given), 3))
    return replace(given, mag_nT=turn.inv().apply(FIELD_ENU_NT) + noise, att_q=turn.as_quat()[:, [3, 0, 1, 2]])


def test_on_level_circles_neither_can_be_told() -> None:
    wrong = pose(_level_circles(), Known(np.array([EAST, NORTH, -UP]), STRENGTH_NT))
    assert find_misread_field(wrong) is None
    assert find_own_compass(wrong) is None


@pytest.mark.parametrize("calibration", [IRON, np.eye(3)], ids=["calibrated", "raw"])
def test_a_heading_made_from_the_magnetometer_is_known(calibration: Array) -> None:
    found = find_own_compass(pose(with_own_compass(0.3, calibration), Known(FIELD_ENU_NT, STRENGTH_NT)))
    assert found is not None
    towards_east, elsewhere = found
    assert towards_east < 1
    assert elsewhere > 40


def test_beside_a_heading_of_its_own_compass_a_current_is_found_by_strength_and_dip() -> None:
    given = {"field_enu_nT": FIELD_ENU_NT, "fitted_base": True}
    quiet = diagnose(with_own_compass(0.3, IRON), ModelSpec(), **given)
    assert quiet.verdict is Verdict.NONE
    assert quiet.problem.compared == quiet.as_dict()["mode"] == "strength+dip"
    assert "very magnetometer: only the field's strength and dip were compared" in quiet.sentence
    found = diagnose(with_own_compass(0.3, IRON, gain_nT_A=60.0), ModelSpec(), without=COSTLY, **given)
    assert [one.name for one in found.named] == ["motor_current"]
    assert found.model.field.enu_nT == pytest.approx(FIELD_ENU_NT)
    (gain,) = (one.effect.gain_nT_A for one in found.named)
    assert gain == pytest.approx((60.0, -30.0, 42.0), abs=3.0)


def test_in_a_field_that_stands_upright_there_is_no_dip_to_compare() -> None:
    posed = pose(with_own_compass(0.3, IRON), Known(FIELD_ENU_NT, STRENGTH_NT, (), replace(STANDARD, trace=0.9)))
    mended = correct_reference(posed)
    assert mended.compared == "strength"
    assert "only the field's strength was compared" in mended.corrections[0].words


def test_a_noisy_heading_of_its_own_is_not_taken_for_it() -> None:
    given, rng = recording(noise_nT=50.0), np.random.default_rng(4)
    assert given.att_q is not None
    off = Rotation.from_euler("ZYX", np.radians([0.1, 0.5, 0.5]) * rng.normal(size=(len(given), 3)))
    turn = Rotation.from_quat(given.att_q[:, [1, 2, 3, 0]]) * off
    noisy = replace(given, att_q=turn.as_quat()[:, [3, 0, 1, 2]])
    assert find_own_compass(pose(noisy, Known(FIELD_ENU_NT, STRENGTH_NT))) is None


def test_a_sensor_with_a_noisy_vertical_axis_is_not_taken_for_it() -> None:
    """In a steep field it has most of its noise along the field, whoever made the heading."""
    given = recording()
    noisy_nT = given.mag_nT + [0.0, 0.0, 50.0] * np.random.default_rng(5).normal(size=(len(given), 3))
    assert find_own_compass(pose(replace(given, mag_nT=noisy_nT), Known(FIELD_ENU_NT, STRENGTH_NT))) is None


def test_a_glider_steers_by_its_own_compass(realdata) -> None:  # type: ignore[no-untyped-def]
    glider = read_recording(realdata / "glider" / "five_dives.parquet")
    place = {"latitude_deg": 12.1, "longitude_deg": 85.9, "date": "2024-05-27"}
    assert find_own_compass(pose_model(glider, ModelSpec.model_validate({"field": place}), None, None)) is not None


def test_an_optical_attitude_is_no_compass(realdata) -> None:  # type: ignore[no-untyped-def]
    place = {"latitude_deg": 52.5, "longitude_deg": 13.4, "date": "2019-06-01"}
    for path in sorted((realdata / "motion-capture").glob("*.parquet")):
        assert (
            find_own_compass(pose_model(read_recording(path), ModelSpec.model_validate({"field": place}), None, None))
            is None
        )


@pytest.mark.parametrize(("axes", "told"), [(4.0, True), (6.0, False)])
def test_a_heading_is_made_of_a_calibration_that_is_nearly_the_sensors(axes: float, told: bool) -> None:
    """``k . (D m - d) = 0`` holds for a D whose axes differ by that: five times are the motion's, no calibration."""
    rng = np.random.default_rng(0)
    m = rng.normal(size=(500, 3)) / np.sqrt(3)
    k = np.cross((m - m.mean(axis=0)) * [1.0, 1.0, axes] - [0.1, 0.2, -0.1], rng.normal(size=(500, 3)))
    k /= np.linalg.norm(k, axis=1, keepdims=True)
    strength_nT = 4e4
    assert (_own_east_nT(k, m * strength_nT, strength_nT, np.eye(3), STANDARD) is not None) is told
