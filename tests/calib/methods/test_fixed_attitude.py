"""The offset of a vehicle that cannot turn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from calib import Reference
from calib.methods.fixed_attitude import FixedAttitude
from recordings import Recording

FIELD_ENU_NT = np.array([900.0, 20_000.0, -43_000.0])
REFERENCE = Reference.of_vector(tuple(FIELD_ENU_NT))
OFFSET_NT = np.array([3_000.0, -1_500.0, 700.0])


def moored(rng, n=600, heading_deg=37.0):
    """x towards heading_deg from north, level, FLU: written out, east and north by sine and cosine."""
    s, c = np.sin(np.radians(heading_deg)), np.cos(np.radians(heading_deg))
    east, north, up = FIELD_ENU_NT
    body_nT = np.array([s * east + c * north, -c * east + s * north, up])
    return Recording(np.arange(n) * 0.1, body_nT + OFFSET_NT + 20.0 * rng.standard_normal((n, 3)))


def test_the_stated_heading_gives_the_offset_within_its_claim():
    fit = FixedAttitude(heading_deg=37.0, field_std_nT=0.0).fit(moored(np.random.default_rng(0)), REFERENCE)
    assert fit.status.kind == "ok"
    assert "offset alone" in fit.status.reason
    error = fit.offset_nT - OFFSET_NT
    assert error @ np.linalg.solve(fit.offset_covariance_nT2, error) < 16.3


def test_a_wrong_heading_is_in_the_claim():
    fit = FixedAttitude(heading_deg=38.0, attitude_std_rad=np.radians(1.0)).fit(
        moored(np.random.default_rng(1)), REFERENCE
    )
    error = fit.offset_nT - OFFSET_NT
    assert np.linalg.norm(error) > 200.0
    assert error @ np.linalg.solve(fit.offset_covariance_nT2, error) < 16.3


def test_the_recorded_attitude_is_used_and_a_turning_vehicle_referred():
    recording = moored(np.random.default_rng(2))
    yaw = Rotation.from_euler("z", np.full((len(recording), 1), 90.0 - 37.0), degrees=True)
    held = replace(recording, att_q=yaw.as_quat(scalar_first=True))
    np.testing.assert_allclose(FixedAttitude().fit(held, REFERENCE).offset_nT, OFFSET_NT, atol=5.0)
    turning = Rotation.from_euler("z", np.linspace(0.0, 360.0, len(recording))[:, None], degrees=True)
    status = FixedAttitude().fit(replace(recording, att_q=turning.as_quat(scalar_first=True)), REFERENCE).status
    assert status.kind == "not_applicable"
    assert "vector_least_squares" in status.reason


def test_without_any_attitude_it_says_what_it_needs():
    status = FixedAttitude().fit(moored(np.random.default_rng(3)), REFERENCE).status
    assert status.kind == "not_applicable"
    assert "heading_deg" in status.reason
