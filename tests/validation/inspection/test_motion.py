"""Coverage of caps of known size, planes, angles and rates."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.arrays import Array
from tests.validation.inspection.recordings import FIELD_ENU_NT, GRAVITY_M_S2, moved, noise, one, sensor_data, still
from validation.inspection.motion import motion_findings

STRENGTH_NT = 50_000.0
CELL_DEG = 15 / np.sqrt(2)
"""From the middle of a cell to its corner."""


def cap(half_angle_deg: float, samples: int = 20_000) -> Array:
    """Field vectors (n, 3), evenly spread within an angle of +z."""
    rng = np.random.default_rng(0)
    z = rng.uniform(np.cos(np.radians(half_angle_deg)), 1, samples)
    turn, radius = rng.uniform(0, 2 * np.pi, samples), np.sqrt(1 - z**2)
    return STRENGTH_NT * np.column_stack([radius * np.cos(turn), radius * np.sin(turn), z])


@pytest.mark.parametrize("half_angle_deg", [20.0, 45.0, 90.0, 120.0])
def test_coverage_of_a_cap(half_angle_deg: float) -> None:
    """A cap of half angle a is (1 - cos a) / 2 of the sphere, and leaves a hole of 180 degrees less a."""
    field_nT = cap(half_angle_deg)
    found = one(motion_findings(sensor_data(np.arange(len(field_nT)) / 50, field_nT)), "coverage")
    edge = 0.35 * np.sin(np.radians(half_angle_deg))  # cells of 15 degrees that the rim touches
    assert 0 <= found.value["share"] - (1 - np.cos(np.radians(half_angle_deg))) / 2 < edge
    assert 0 <= 180 - half_angle_deg - found.value["hole_deg"] < CELL_DEG  # seen from the middle of a cell
    assert found.value["hole_at"][2] < -np.cos(np.radians(CELL_DEG))
    assert found.level == ("ok" if half_angle_deg > 115 else "note")
    assert "-z" in found.text


def test_the_largest_hole_is_told_where_it_is() -> None:
    """Half a sphere about (0, 0.8, -0.6): the hole's middle is on the other side."""
    field_nT = cap(90.0)[:, [0, 2, 1]] @ np.array([[1, 0, 0], [0, 0.8, -0.6], [0, 0.6, 0.8]])
    found = one(motion_findings(sensor_data(np.arange(len(field_nT)) / 50, field_nT)), "coverage")
    x, y, z = found.value["hole_at"]
    assert y == pytest.approx(-0.8, abs=0.15)
    assert f"about -y (direction {x:.2f}, {y:.2f}, {z:.2f})" in found.text


def test_the_whole_sphere_has_no_hole() -> None:
    field_nT = STRENGTH_NT * noise(20_000, 1.0)
    field_nT *= STRENGTH_NT / np.linalg.norm(field_nT, axis=1, keepdims=True)
    found = one(motion_findings(sensor_data(np.arange(20_000) / 50, field_nT)), "coverage")
    assert found.value["share"] == 1.0
    assert found.value["hole_deg"] < 3


def test_a_level_turn_lies_in_a_plane() -> None:
    """A circle of radius r has a standard deviation of r / sqrt(2) along two directions, and none across."""
    turn = np.linspace(0, 6 * np.pi, 3000)
    field_nT = np.column_stack([20_000 * np.cos(turn), 20_000 * np.sin(turn), np.full(3000, 40_000.0)])
    found = one(motion_findings(sensor_data(np.arange(3000) / 50, field_nT + noise(3000, 5.0))), "extent")
    assert found.value[:2] == pytest.approx([20_000 / np.sqrt(2)] * 2, rel=0.01)
    assert found.value[2] == pytest.approx(5.0, rel=0.05)
    assert "the field lies in a plane perpendicular to body z" in found.text


def test_a_sensor_at_rest() -> None:
    time_s, field_nT = still(3000)
    assert "at rest" in one(motion_findings(sensor_data(time_s, field_nT + noise(3000, 5.0))), "extent").text
    assert "does not vary" in one(motion_findings(sensor_data(time_s, field_nT)), "extent").text


def test_angles_of_the_attitude_and_of_the_accelerometer() -> None:
    """Pitch within 0.8 rad either way; the roll's arc by gravity alone is the same."""
    motion = moved(3000, reach_rad=0.8)
    mag_nT = motion.body(FIELD_ENU_NT)
    by_attitude = one(motion_findings(sensor_data(motion.time_s, mag_nT, q=motion.q)), "angles").value
    assert by_attitude["pitch_deg"] == pytest.approx(np.degrees(1.6), abs=0.1)
    assert by_attitude["roll_deg"] == pytest.approx(np.degrees(1.6), abs=0.1)
    assert by_attitude["heading_deg"] > 355
    accel = motion.body(np.array([0.0, 0.0, GRAVITY_M_S2]))
    by_gravity = one(motion_findings(sensor_data(motion.time_s, mag_nT, accel=accel)), "angles").value
    assert by_gravity == pytest.approx({key: by_attitude[key] for key in ("roll_deg", "pitch_deg")}, abs=0.01)


def test_an_arc_across_north_is_short() -> None:
    """Headings from 350 to 10 degrees span 20, not 340."""
    yaw = np.radians(10 * np.sin(np.linspace(0, 20, 2000)))
    q = np.column_stack([np.cos(yaw / 2), 0 * yaw, 0 * yaw, np.sin(yaw / 2)])
    found = one(motion_findings(sensor_data(np.arange(2000) / 50, noise(2000, 5.0) + 2e4, q=q)), "angles")
    assert found.value["heading_deg"] == pytest.approx(20, abs=0.1)


def test_a_turn_at_a_constant_rate_hides_eddy_currents() -> None:
    gyro = np.tile([0.0, 0.0, np.radians(12.0)], (2000, 1)) + noise(2000, 1e-3)
    turned = motion_findings(sensor_data(np.arange(2000) / 50, noise(2000, 5.0) + 2e4, gyro=gyro))
    found = one(turned, "rate")
    assert "turns at 12 deg/s about body z" in found.text
    assert "eddy currents cannot be distinguished from soft iron" in found.text
    assert found.value["steady_share"] > 0.99


def test_the_rate_is_the_attitudes_where_there_is_no_gyro() -> None:
    motion = moved(3000)
    expected = np.degrees(np.sqrt((motion.rate_rad_s**2).sum(axis=1).mean()))
    for columns in ({"gyro": motion.rate_rad_s}, {"q": motion.q}):
        found = one(motion_findings(sensor_data(motion.time_s, motion.body(FIELD_ENU_NT), **columns)), "rate")
        assert found.value["rate_deg_s"] == pytest.approx(expected, rel=2e-3)
        assert "not at a constant rate" in found.text


def test_too_few_rows() -> None:
    assert motion_findings(sensor_data(np.arange(2.0), np.ones((2, 3)))) == []
