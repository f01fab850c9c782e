"""Known coefficients through a simulated scalar magnetometer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from calib import get
from calib.methods.tolles_lawson import NAMES, REDUNDANT, TollesLawsonCalibrator, band_passed, compensated, terms

PERMANENT_NT = np.array([30.0, -12.0, 20.0])
INDUCED = np.array([[4e-4, 1e-4, -2e-4], [1e-4, -3e-4, 5e-5], [-2e-4, 5e-5, 0.0]])
EDDY_S = np.array([[2e-3, 1e-3, -5e-4], [7e-4, -1e-3, 4e-4], [3e-4, -6e-4, 0.0]])


def scalar_recording(standard, seed, noise_std_nT=0.05, motion="full"):
    """A good vector sensor, and a scalar one that adds the vehicle's field along the Earth's."""
    clean = standard.recording(motion, None, soft=np.eye(3))
    field_nT = clean.mag_nT - standard.HARD_NT
    rate_nT_s = -np.cross(clean.gyro_rad_s, field_nT)
    vehicle_nT = PERMANENT_NT + field_nT @ INDUCED.T + rate_nT_s @ EDDY_S.T
    strength_nT = np.linalg.norm(field_nT + vehicle_nT, axis=1)
    noise_nT = np.random.default_rng(seed).normal(0.0, noise_std_nT, len(clean))
    drift_nT = 40.0 * np.sin(2 * np.pi * clean.time_s / 3000.0)
    return replace(clean, mag_nT=field_nT, channels={"scalar_nT": strength_nT + noise_nT + drift_nT}), drift_nT


def test_known_coefficients_are_recovered(standard):
    recording, _ = scalar_recording(standard, 0)
    fit = get("tolles_lawson").fit(recording, standard.REFERENCE)
    assert fit.status.kind == "ok"
    found = [fit.parameters[f"permanent_{i}_nT"] for i in "xyz"]
    np.testing.assert_allclose(found, PERMANENT_NT, atol=0.2)
    # Sixteen terms know A up to a multiple of I, and u . du/dt = 0: the truth above has both at zero.
    for name in ("xx", "xy", "yz", "yy"):
        i, j = ("xyz".index(c) for c in name)
        assert fit.parameters[f"induced_{name}"] == pytest.approx(INDUCED[i, j], abs=1e-5)
        assert fit.parameters[f"eddy_{name}_s"] == pytest.approx(EDDY_S[i, j], abs=1e-4)


def test_vehicle_is_taken_out_and_the_earths_drift_stays(standard):
    recording, drift_nT = scalar_recording(standard, 1)
    fit = get("tolles_lawson").fit(recording, standard.REFERENCE)
    left_nT = compensated(fit, recording, standard.REFERENCE) - drift_nT
    raw_nT = recording.channels["scalar_nT"] - drift_nT
    assert left_nT.std() < 0.2 < 10.0 < raw_nT.std()
    assert fit.parameters["improvement_ratio"] > 20


def test_sixteen_and_eighteen_terms_say_the_same(standard):
    recording, _ = scalar_recording(standard, 2)
    two = [TollesLawsonCalibrator(terms=k).fit(recording, standard.REFERENCE) for k in (16, 18)]
    assert [len(fit.covariance_names) for fit in two] == [16, 18]
    one, other = (compensated(fit, recording, standard.REFERENCE) for fit in two)
    assert (one - other).std() < 0.1
    assert two[1].parameters["condition_number"] > 100 * two[0].parameters["condition_number"]


def test_the_two_terms_left_out_are_tied_to_the_others(standard):
    recording, _ = scalar_recording(standard, 3)
    columns = terms(recording, standard.REFERENCE.strength_nT)
    index = {name: k for k, name in enumerate(NAMES)}
    squares = sum(columns[:, index[f"induced_{a}"]] for a in ("xx", "yy", "zz"))
    np.testing.assert_allclose(squares, standard.REFERENCE.strength_nT, rtol=1e-12)
    radial = sum(columns[:, index[f"eddy_{a}_s"]] for a in ("xx", "yy", "zz"))
    assert np.abs(radial[5:-5]).max() < 1e-3 * np.abs(columns[:, index["eddy_xy_s"]]).max()
    assert set(REDUNDANT) < set(NAMES)


def test_errors_match_claims(standard):
    fits = [get("tolles_lawson").fit(scalar_recording(standard, s, 1.0)[0], standard.REFERENCE) for s in range(8)]
    errors = np.array([[f.parameters[f"permanent_{i}_nT"] for i in "xyz"] - PERMANENT_NT for f in fits])
    claimed = np.mean([np.sqrt(np.diag(f.covariance)[:3]) for f in fits], axis=0)
    ratio = np.sqrt((errors**2).mean(axis=0)) / claimed
    # The second order of the vehicle's field, |dT|^2 / 2F of about 0.01 nT, adds a little.
    assert (ratio < 3).all()
    assert (ratio > 0.4).all()


def test_band_keeps_the_middle_and_drops_both_ends():
    time_s = np.arange(20_000) / 10.0
    for f_hz, low, high in ((0.0005, 0.0, 0.02), (0.07, 0.95, 1.0), (3.0, 0.0, 0.02)):
        wave = np.sin(2 * np.pi * f_hz * time_s)[:, None]
        kept = band_passed(wave, time_s, (0.01, 0.5))[5000:15_000].std() / wave[5000:15_000].std()
        assert low <= kept <= high + 1e-3


def test_needs_the_scalar_channel(standard):
    status = get("tolles_lawson").fit(standard.recording("full", 0), standard.REFERENCE).status
    assert status.kind == "not_applicable"
    assert "scalar_nT" in status.reason
