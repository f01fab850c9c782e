"""Strength and dip against the motion of a boat made here."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib import Reference, get
from calib.methods.strength_dip import StrengthDip
from recordings import Recording
from tests.nightly import first_daily

FIELD_ENU_NT = 48_000.0 * np.array([0.0, np.cos(np.radians(64.0)), -np.sin(np.radians(64.0))])
SOFT = np.array([[1.05, 0.02, -0.01], [0.02, 0.96, 0.015], [-0.01, 0.015, 1.01]])
HARD_NT = np.array([12_000.0, -8_000.0, 25_000.0])
STRENGTH, VECTOR = Reference(48_000.0), Reference.of_vector(tuple(FIELD_ENU_NT))


def boat(rng, roll_deg=40.0, accelerations_m_s2=0.05, noise_nT=100.0, mounted=(0.0, 0.0, 0.0), n=1200):
    time_s = np.arange(n) * 0.1
    roll = np.radians(roll_deg) * np.sin(2 * np.pi * time_s / 7.3)
    pitch = np.radians(5.0) * np.sin(2 * np.pi * time_s / 5.1)
    attitude = Rotation.from_euler("ZYX", np.column_stack((np.radians(3.0) * time_s, pitch, roll))).inv()
    mag_nT = attitude.apply(FIELD_ENU_NT) @ SOFT + HARD_NT + noise_nT * rng.standard_normal((n, 3))
    force = attitude.apply([0.0, 0.0, 9.80665]) + accelerations_m_s2 * rng.standard_normal((n, 3))
    return Recording(time_s, mag_nT, accel_m_s2=Rotation.from_rotvec(mounted).apply(force))


def test_without_noise_all_is_found_in_the_axes_of_the_accelerometer():
    mounted = (0.05, -0.03, 0.1)
    fit = StrengthDip().fit(boat(np.random.default_rng(0), 60.0, 0.0, 0.0, mounted), STRENGTH)
    assert fit.status.kind == "ok", fit.status
    np.testing.assert_allclose(fit.offset_nT, HARD_NT, atol=0.1)
    np.testing.assert_allclose(fit.matrix, Rotation.from_rotvec(mounted).as_matrix() @ np.linalg.inv(SOFT), atol=1e-5)
    assert fit.parameters["inclination_rad"] == pytest.approx(np.radians(-64.0), abs=1e-6)


@pytest.mark.parametrize("reference", first_daily([STRENGTH, VECTOR]))
def test_the_claim_holds_the_offset_in_95_percent(reference):
    rng = np.random.default_rng(1)
    distances = []
    for _ in range(60):
        fit = StrengthDip().fit(boat(rng, n=400), reference)
        error = fit.offset_nT - HARD_NT
        distances.append(error @ np.linalg.solve(fit.offset_covariance_nT2, error))
    assert np.mean(np.array(distances) < 7.815) > 0.95 - 3 * np.sqrt(0.05 * 0.95 / 60)


def test_it_determines_what_the_ellipsoid_leaves_open():
    recording = boat(np.random.default_rng(2), 25.0)
    alone, both = get("ellipsoid").fit(recording, VECTOR), StrengthDip().fit(recording, VECTOR)
    wide, narrow = (np.sqrt(np.trace(fit.offset_covariance_nT2)) for fit in (alone, both))
    assert narrow < 0.5 * wide


def test_without_an_accelerometer_it_says_what_to_record():
    recording = boat(np.random.default_rng(3))
    fit = StrengthDip().fit(Recording(recording.time_s, recording.mag_nT), STRENGTH)
    assert fit.status.kind == "not_applicable"
    assert "accel" in fit.status.reason
