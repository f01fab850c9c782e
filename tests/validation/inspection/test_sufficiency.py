"""Which calibrations a motion is enough for, where theory says so."""

from __future__ import annotations

import numpy as np

from tests.validation.inspection.recordings import FIELD_ENU_NT, moved, noise, one, sensor_data
from validation.inspection.sufficiency import calibration_findings

SAMPLES, STD_NT = 3000, 5.0
MOTION = moved(SAMPLES)
OFFSET_NT = np.array([300.0, -200.0, 100.0])
MAG_NT = MOTION.body(FIELD_ENU_NT) + OFFSET_NT + noise(SAMPLES, STD_NT)


def test_a_full_motion_with_attitude_is_enough_for_all() -> None:
    found = calibration_findings(sensor_data(MOTION.time_s, MAG_NT, q=MOTION.q))
    assert one(found, "enough_for").value == ["sphere", "ellipsoid", "vector_least_squares", "eddy"]
    assert {finding.level for finding in found} == {"ok"}


def test_without_attitude_the_vector_kinds_are_not_spoken_of() -> None:
    found = calibration_findings(sensor_data(MOTION.time_s, MAG_NT))
    assert one(found, "enough_for").value == ["sphere", "ellipsoid"]
    assert "vector" not in " ".join(finding.name for finding in found)


def test_a_soft_iron_is_too_much_for_a_sphere() -> None:
    """Its residual is no noise, so that its offset is less sure than it must be."""
    found = calibration_findings(sensor_data(MOTION.time_s, MAG_NT * [1.05, 0.97, 1.0]))
    assert one(found, "enough_for").value == ["ellipsoid"]


def test_the_spread_of_the_strength_before_and_after() -> None:
    """An offset b along the motion spreads |h + b| by about b.u; after the fit the noise of 5 in 47,500 nT is left."""
    value = one(calibration_findings(sensor_data(MOTION.time_s, MAG_NT)), "strength_spread").value
    strength = np.linalg.norm(MAG_NT, axis=1)
    assert abs(value["raw_percent"] - 100 * strength.std() / strength.mean()) < 1e-6
    assert abs(value["ellipsoid_percent"] - 100 * STD_NT / np.linalg.norm(FIELD_ENU_NT)) < 0.001


def test_a_level_turn_is_enough_for_planar_alone() -> None:
    """The offset across a plane cannot be distinguished from the strength; and the reason says so."""
    turn = np.linspace(0, 6 * np.pi, SAMPLES)
    flat = np.column_stack([20_000 * np.cos(turn), 20_000 * np.sin(turn), np.full(SAMPLES, 40_000.0)])
    found = calibration_findings(sensor_data(MOTION.time_s, flat + noise(SAMPLES, STD_NT)))
    assert one(found, "enough_for").value == ["planar"]
    assert "cannot be determined: the measurements lie in a plane" in one(found, "enough_for_sphere").text
    assert one(found, "enough_for_sphere").value["status"] == "unobservable"
    assert "do not suffice" in one(found, "enough_for_ellipsoid").text


def test_a_field_that_changes_by_itself_is_the_reason_and_not_the_motion() -> None:
    """Steps of 500 nT that go with no attitude, in a motion that is wide enough."""
    steps = 500.0 * np.sign(np.sin(MOTION.time_s * 0.31))[:, None] * [1.0, 0.5, -0.7]
    found = calibration_findings(sensor_data(MOTION.time_s, MAG_NT + 6 * steps, q=MOTION.q))
    reasons = " ".join(finding.text for finding in found if finding.level != "ok")
    assert "are not of the attitude" in reasons
    assert "the field itself changes" in reasons


def test_too_few_rows() -> None:
    assert calibration_findings(sensor_data(MOTION.time_s[:2], MAG_NT[:2])) == []
