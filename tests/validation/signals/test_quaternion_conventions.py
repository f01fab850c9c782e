"""Conventions, rates and directions of a motion whose angles and rates are known by formula."""

from __future__ import annotations

import numpy as np
import pytest

from tests.validation.inspection.recordings import FIELD_ENU_NT, RATE_HZ, moved, noise
from validation.signals.quaternion_conventions import (
    CONVENTIONS,
    euler_deg,
    gyro_scale_from_field,
    match_rates,
    mean_direction,
    read_as,
)

SAMPLES = 2000
MOTION = moved(SAMPLES)
WRITTEN = {
    "w, x, y, z, body to world": MOTION.q,
    "w, x, y, z, world to body": MOTION.q * [1, -1, -1, -1],
    "x, y, z, w, body to world": MOTION.q[:, [1, 2, 3, 0]],
    "x, y, z, w, world to body": (MOTION.q * [1, -1, -1, -1])[:, [1, 2, 3, 0]],
}


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_each_convention_is_read_back(convention: str) -> None:
    np.testing.assert_array_equal(read_as(WRITTEN[convention], convention), MOTION.q)


def test_euler_angles_are_those_that_made_the_motion() -> None:
    t = MOTION.time_s
    yaw, pitch, roll = euler_deg(MOTION.q).T
    np.testing.assert_allclose(pitch, np.degrees(1.2 * np.sin(0.9 * t)), atol=1e-9)
    np.testing.assert_allclose(roll, np.degrees(1.2 * np.sin(1.3 * t + 1)), atol=1e-9)
    np.testing.assert_allclose(np.unwrap(yaw, period=360), np.degrees(0.5 * t + 0.6 * np.sin(0.7 * t)), atol=1e-9)


@pytest.mark.parametrize("late", [0, 12, -7])
@pytest.mark.parametrize("scale", [1.0, 57.3])
def test_scale_turn_and_lag_between_the_rates(scale: float, late: int) -> None:
    """gyro = scale R omega + bias, R a turn by 30 degrees about z, and the attitude so many rows late."""
    c, s = np.cos(np.radians(30)), np.sin(np.radians(30))
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    gyro = scale * (MOTION.rate_rad_s @ R.T + [0.02, -0.01, 0.03])
    found = match_rates(MOTION.time_s, np.roll(MOTION.q, late, axis=0), gyro)
    assert found is not None
    assert found.share > 0.98
    assert found.scale == pytest.approx(scale, rel=0.02)
    assert found.angle_deg == pytest.approx(30, abs=1)
    assert found.lag_s == pytest.approx(late / RATE_HZ)


def test_noise_in_the_gyro_lowers_the_share() -> None:
    """Means over five rows: share = 1 - s^2 / 5 over the variance of the rate, about."""
    std = 0.8
    found = match_rates(MOTION.time_s, MOTION.q, MOTION.rate_rad_s + noise(SAMPLES, std))
    assert found is not None
    signal = MOTION.rate_rad_s.var(axis=0).sum()
    assert found.share == pytest.approx(signal / (signal + 3 * std**2 / 5), abs=0.03)


def test_about_one_axis_the_turn_cannot_be_told() -> None:
    yaw = 0.8 * np.sin(MOTION.time_s)
    q = np.column_stack([np.cos(yaw / 2), 0 * yaw, 0 * yaw, np.sin(yaw / 2)])
    gyro = np.column_stack([0 * yaw, 0 * yaw, 0.8 * np.cos(MOTION.time_s)])
    found = match_rates(MOTION.time_s, q, gyro)
    assert found is not None
    assert found.share > 0.99
    assert np.isnan(found.angle_deg)


def test_what_does_not_turn_or_is_short_is_not_compared() -> None:
    still = np.tile(MOTION.q[:1], (SAMPLES, 1))
    assert match_rates(MOTION.time_s, still, 0 * MOTION.rate_rad_s) is None
    assert match_rates(MOTION.time_s[:20], MOTION.q[:20], MOTION.rate_rad_s[:20]) is None


def test_mean_direction_is_one_long_where_it_is_kept() -> None:
    world = FIELD_ENU_NT / np.linalg.norm(FIELD_ENU_NT)
    np.testing.assert_allclose(mean_direction(MOTION.q, MOTION.body(FIELD_ENU_NT)), world, atol=1e-12)
    shuffled = np.random.default_rng(0).permutation(MOTION.body(FIELD_ENU_NT))
    assert np.linalg.norm(mean_direction(MOTION.q, shuffled)) < 0.9
    assert mean_direction(MOTION.q, np.full((SAMPLES, 3), np.nan)).tolist() == [0, 0, 0]


@pytest.mark.parametrize("factor", [1.0, 180 / np.pi])
def test_the_fields_turning_tells_the_gyros_scale(factor: float) -> None:
    """dm/dt = -omega x (m - b), with an offset of 3000 nT: the scale is that of the gyro's unit."""
    mag_nT = MOTION.body(FIELD_ENU_NT) + np.array([3000.0, -1000.0, 500.0])
    scale, share = gyro_scale_from_field(MOTION.time_s, mag_nT, factor * MOTION.rate_rad_s)
    assert scale * factor == pytest.approx(1, rel=0.01)
    assert share > 0.99


def test_a_gyro_at_rest_has_no_scale() -> None:
    assert np.isnan(gyro_scale_from_field(MOTION.time_s, MOTION.body(FIELD_ENU_NT), 0 * MOTION.rate_rad_s)).all()
    assert np.isnan(gyro_scale_from_field(MOTION.time_s[:20], MOTION.q[:20, 1:], MOTION.rate_rad_s[:20])).all()
