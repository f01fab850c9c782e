"""What is derived of one magnetometer: unit, slower sensors, held attitude, and the base model's rest."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.arrays import Array
from tests.validation.inspection.recordings import FIELD_ENU_NT, RATE_HZ, moved, noise, sensor_data, series
from validation.inspection.sensor_data import attitude_of, median_strength

SAMPLES, STD_NT = 3000, 5.0
MOTION = moved(SAMPLES)
SOFT_IRON = np.array([[1.05, 0.02, 0.0], [0.01, 0.97, -0.03], [0.0, 0.02, 1.02]])
"""Not symmetric: the strength cannot tell the turn in it, the attitude can."""
MAG_NT = MOTION.body(FIELD_ENU_NT) @ SOFT_IRON.T + [300.0, -200.0, 100.0] + noise(SAMPLES, STD_NT)


def test_the_series_is_taken_in_the_unit_that_its_strength_suggests() -> None:
    given, derived = sensor_data(MOTION.time_s, MAG_NT), sensor_data(MOTION.time_s, MAG_NT / 1e3)
    assert (given.unit, derived.unit) == ("nT", "uT")
    np.testing.assert_allclose(derived.series.mag_nT, MAG_NT, rtol=1e-12)
    assert derived.strength_nT == pytest.approx(np.median(np.linalg.norm(MAG_NT, axis=1)))


def test_noise_rate_and_evenness() -> None:
    found = sensor_data(MOTION.time_s, MAG_NT)
    np.testing.assert_allclose(found.white_nT, STD_NT, rtol=0.05)
    assert found.settled
    assert found.rate_hz == pytest.approx(RATE_HZ)
    assert found.even
    assert len(found.fresh) == SAMPLES


def test_rows_that_a_slower_sensor_repeats_are_left_out() -> None:
    """12.5 Hz in rows of 50 Hz: one row in four is new, its noise is that of the sensor."""
    found = sensor_data(MOTION.time_s, np.repeat(MAG_NT[::4], 4, axis=0))
    assert len(found.fresh) == SAMPLES // 4
    assert found.rate_hz == pytest.approx(RATE_HZ / 4, rel=1e-3)
    np.testing.assert_allclose(found.white_nT, STD_NT, rtol=0.1)


def test_every_second_interval_double_is_uneven() -> None:
    keep = np.flatnonzero(np.arange(SAMPLES) % 3 != 2)
    assert not sensor_data(MOTION.time_s[keep], MAG_NT[keep]).even


def test_the_attitudes_base_explains_any_iron() -> None:
    """m = S R^T h + b with ten coefficients an axis: noise is left."""
    residual = sensor_data(MOTION.time_s, MAG_NT, q=MOTION.q).residual
    assert residual is not None
    assert residual.base == "attitude"
    np.testing.assert_allclose(residual.values.std(axis=0), STD_NT * np.sqrt(1 - 10 / SAMPLES), rtol=0.04)


def test_without_attitude_the_ellipsoid_is_the_base() -> None:
    residual = sensor_data(MOTION.time_s, MAG_NT).residual
    assert residual is not None
    assert residual.base == "strength"
    assert residual.values.shape == (SAMPLES, 1)
    assert residual.values.std() == pytest.approx(STD_NT, rel=0.06)


def test_without_enough_motion_the_mean_is() -> None:
    residual = sensor_data(MOTION.time_s, noise(SAMPLES, STD_NT) + 2e4).residual
    assert residual is not None
    assert residual.base == "mean"
    np.testing.assert_allclose(residual.values.mean(axis=0), 0, atol=1e-9)


def test_a_field_that_is_not_constant_is_not_corrected() -> None:
    """The ellipsoid fit of a field whose strength doubles has not found the field."""
    assert sensor_data(MOTION.time_s, MAG_NT).corrected_nT is not None
    growing = MAG_NT * np.linspace(1, 2, SAMPLES)[:, None]
    assert sensor_data(MOTION.time_s, growing).corrected_nT is None


def _angle_deg(q: Array, true: Array) -> Array:
    return np.degrees(2 * np.arccos(np.clip(np.abs((q * true).sum(axis=1)), -1, 1)))


def test_a_held_attitude_is_interpolated() -> None:
    """10 Hz in rows of 50 Hz: a chord is off by (0.1 s)^2 / 8 times 3 rad/s^2, held values by 0.08 s times the rate."""
    held = np.repeat(MOTION.q[::5], 5, axis=0)
    signs = np.where(np.arange(SAMPLES // 5) % 2, -1.0, 1.0).repeat(5)[:, None]
    q = attitude_of(series(MOTION.time_s, MAG_NT, q=held * signs))
    assert q is not None
    known = np.isfinite(q).all(axis=1)
    assert known.sum() >= SAMPLES - 5
    assert _angle_deg(held, MOTION.q).max() > 2
    assert _angle_deg(q[known], MOTION.q[known]).max() < np.degrees(0.1**2 / 8 * 3)


def test_rows_without_attitude_are_bridged_and_ends_are_not() -> None:
    q = MOTION.q.copy()
    q[:100], q[500:503] = np.nan, np.nan
    found = attitude_of(series(MOTION.time_s, MAG_NT, q=q))
    assert found is not None
    assert np.isnan(found[:100]).all()
    assert _angle_deg(found[500:503], MOTION.q[500:503]).max() < 0.1


def test_no_attitude() -> None:
    assert attitude_of(series(MOTION.time_s, MAG_NT)) is None
    assert attitude_of(series(MOTION.time_s, MAG_NT, q=0 * MOTION.q)) is None


def test_nothing_has_no_strength() -> None:
    assert np.isnan(median_strength(np.zeros((0, 3))))
    empty = sensor_data(np.zeros(0), np.zeros((0, 3)))
    assert empty.residual is None
    assert np.isnan(empty.rate_hz)
    assert not empty.even
