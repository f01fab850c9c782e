"""The planar calibration against ellipses made here."""

from __future__ import annotations

import numpy as np
import pytest

from calib import Reference
from calib.methods.planar import Planar
from recordings import Recording

HORIZONTAL_NT, VERTICAL_NT = 21_000.0, -43_000.0
SOFT = np.array([[1.05, 0.02], [0.02, 0.96]])
CENTRE_NT = np.array([12_000.0, -8_000.0])
STRENGTH = Reference(float(np.hypot(HORIZONTAL_NT, VERTICAL_NT)))
VECTOR = Reference.of_vector((0.0, HORIZONTAL_NT, VERTICAL_NT))


def turn(rng, n=400, span_deg=360.0, noise_nT=150.0, gain=1.0):
    azimuth = np.radians(np.linspace(0.0, span_deg, n) + rng.uniform(0.0, 360.0))
    level = HORIZONTAL_NT * np.column_stack((np.cos(azimuth), np.sin(azimuth))) @ SOFT + CENTRE_NT
    mag_nT = np.column_stack((level, np.full(n, VERTICAL_NT + 25_000.0))) + noise_nT * rng.standard_normal((n, 3))
    return Recording(np.arange(n) * 0.1, gain * mag_nT)


def test_without_noise_the_ellipse_is_found():
    fit = Planar().fit(turn(np.random.default_rng(0), noise_nT=0.0), VECTOR)
    assert fit.status.kind == "ok"
    np.testing.assert_allclose(fit.offset_nT[:2], CENTRE_NT, atol=1e-4)
    np.testing.assert_allclose(np.linalg.inv(fit.matrix[:2, :2]), SOFT, atol=1e-8)


def test_the_claim_holds_the_centre_in_95_percent():
    rng = np.random.default_rng(1)
    distances = []
    for _ in range(300):
        fit = Planar().fit(turn(rng, int(rng.integers(40, 500)), rng.uniform(200.0, 360.0)), STRENGTH)
        error = fit.offset_nT[:2] - CENTRE_NT
        distances.append(error @ np.linalg.solve(fit.covariance[:2, :2], error))
    held = np.mean(np.array(distances) < 5.991)
    assert 0.95 - 3 * np.sqrt(0.05 * 0.95 / 300) < held < 0.95 + 3 * np.sqrt(0.05 * 0.95 / 300)


def test_an_arc_does_not_determine_the_centre():
    fit = Planar().fit(turn(np.random.default_rng(2), span_deg=60.0), STRENGTH)
    assert fit.status.kind != "ok"


@pytest.mark.parametrize("gain", [1e-3, 0.07, 1.0, 40.0])
def test_status_and_heading_do_not_depend_on_the_unit(gain):
    fit = Planar().fit(turn(np.random.default_rng(3), gain=gain), STRENGTH)
    assert fit.status.kind == "ok"
    assert "z is not determined" in fit.status.reason
    np.testing.assert_allclose(fit.offset_nT[:2] / gain, CENTRE_NT, atol=60.0)
    assert "offset_z_nT" not in fit.covariance_names


def test_a_tumble_and_a_turn_on_edge_are_for_other_methods():
    rng = np.random.default_rng(4)
    directions = rng.standard_normal((500, 3))
    tumble = 48_000.0 * directions / np.linalg.norm(directions, axis=1)[:, None]
    assert "ellipsoid" in Planar().fit(Recording(np.arange(500) * 0.1, tumble), STRENGTH).status.reason
    level = turn(rng)
    on_edge = Recording(level.time_s, level.mag_nT[:, [2, 0, 1]])
    assert "name the level axes" in Planar().fit(on_edge, STRENGTH).status.reason
