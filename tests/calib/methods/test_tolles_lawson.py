"""Known coefficients through a simulated scalar magnetometer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib import Reference, get
from calib.methods.tolles_lawson import TollesLawsonCalibrator
from calib.models.scalar_terms import NAMES, REDUNDANT, compensated, terms
from calib.numerics.bands import band_passed, manoeuvre_band
from recordings import Recording

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
    left_nT = compensated(fit, recording) - drift_nT
    raw_nT = recording.channels["scalar_nT"] - drift_nT
    assert left_nT.std() < 0.2 < 10.0 < raw_nT.std()
    assert fit.parameters["improvement_ratio"] > 20


def test_sixteen_and_eighteen_terms_say_the_same(standard):
    recording, _ = scalar_recording(standard, 2)
    two = [TollesLawsonCalibrator(terms=k).fit(recording, standard.REFERENCE) for k in (16, 18)]
    assert [len(fit.covariance_names) for fit in two] == [16, 18]
    one, other = (compensated(fit, recording) for fit in two)
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


def flight(seed: int, vehicle_nT: float) -> tuple[Recording, Reference]:
    """Pitch, roll and yaw on four headings, in a field that changes along the line, by a scalar and a noisy vector."""
    rng, strength_nT = np.random.default_rng(seed), 50_000.0
    time_s = np.arange(4800) / 10.0
    leg, part = time_s // 120.0, time_s % 120.0 // 30.0
    swing = np.radians(rng.uniform(5, 10)) * np.sin(2 * np.pi * time_s / rng.uniform(5, 10))
    turns = np.where(part == 3, time_s % 30.0 / 30.0, 0.0)
    yaw, pitch, roll = (np.where(part == k, swing, 0.0) for k in range(3))
    turn = Rotation.from_euler("ZYX", np.column_stack([np.pi / 2 * (leg + turns) + yaw, pitch, roll]))
    field_nT = turn.inv().apply([0.0, 0.4 * strength_nT, -np.sqrt(0.84) * strength_nT])
    earth_nT = 25.0 * np.sin(2 * np.pi * time_s / 100.0)
    vehicle = vehicle_nT * (rng.normal(size=3) + field_nT / strength_nT @ rng.normal(size=(3, 3)))
    scalar_nT = np.linalg.norm(field_nT * (1 + earth_nT / strength_nT)[:, None] + vehicle, axis=1)
    channels = {"scalar_nT": scalar_nT + rng.normal(0.0, 0.02, len(time_s)), "earth_nT": earth_nT}
    noisy = field_nT + rng.normal(0.0, 50.0, field_nT.shape)
    return Recording(time_s, noisy, channels=channels), Reference(strength_nT)


def in_band_std(values: np.ndarray, time_s: np.ndarray) -> float:
    return float(band_passed(values[:, None], time_s, (0.1, 0.9))[50:-50].std())


@pytest.mark.parametrize("seed", range(6))
def test_without_a_vehicles_field_every_term_is_zero_and_it_is_not_ok(seed):
    recording, reference = flight(seed, 0.0)
    found = get("tolles_lawson").fit(recording, reference)
    assert found.status.kind == "unobservable"
    assert "below what this log can determine" in found.status.reason
    assert not any(found.parameters.get(name, 0.0) for name in NAMES)
    std = np.sqrt(np.diag(found.covariance))
    assert (std[:3] > 0).all()


@pytest.mark.parametrize("vehicle_nT", [3.0, 30.0])
@pytest.mark.parametrize("seed", range(4))
def test_a_heading_that_the_fit_has_not_seen_is_compensated_as_claimed(seed, vehicle_nT):
    recording, reference = flight(seed, vehicle_nT)
    fit = get("tolles_lawson").fit(recording.taken(slice(0, 3600)), reference)
    assert fit.status.kind == "ok"
    unseen = recording.taken(slice(3600, None))
    raw_nT, left_nT = unseen.channels["scalar_nT"], compensated(fit, unseen)
    before, after = in_band_std(raw_nT, unseen.time_s), in_band_std(left_nT, unseen.time_s)
    assert after < before / 2
    assert after < 4.0 * fit.parameters["held_out_rms_nT"]


@pytest.mark.parametrize("seed", [1, 2])
def test_one_heading_does_not_tell_what_the_vehicle_does_on_others(seed):
    """The held-out parts gain on that heading; a quarter turn away the terms that are not seen would be added."""
    recording, reference = flight(seed, 30.0)
    fit = get("tolles_lawson").fit(recording.taken(slice(0, 1200)), reference)
    assert fit.parameters["improvement_ratio"] > 2.0
    assert fit.status.kind == "unobservable"
    assert "on other headings" in fit.status.reason
    assert not any(fit.parameters.get(name, 0.0) for name in NAMES)


def test_a_given_band_and_ridge_are_used(standard):
    recording, reference = flight(1, 30.0)
    fit = TollesLawsonCalibrator(band_hz=(0.05, 0.6), ridge=1e-6).fit(recording, reference)
    assert [fit.parameters[name] for name in ("band_low_hz", "band_high_hz", "ridge")] == [0.05, 0.6, 1e-6]


def test_a_record_too_short_for_the_band_says_how_long():
    recording, reference = flight(1, 30.0)
    fit = TollesLawsonCalibrator(band_hz=(0.005, 0.6)).fit(recording.taken(slice(0, 1200)), reference)
    assert fit.status.kind == "unobservable"
    assert "record 600 s or more" in fit.status.reason


@pytest.mark.parametrize(("period_s", "low_hz", "high_hz"), [(5.0, 0.1, 0.9), (50.0, 0.01, 0.12)])
def test_the_band_follows_the_manoeuvre_and_leaves_the_noise_out(period_s, low_hz, high_hz):
    time_s = np.arange(6000) / 10.0
    swing = 0.1 * np.sin(2 * np.pi * time_s / period_s) + np.random.default_rng(0).normal(0.0, 0.003, 6000)
    assert manoeuvre_band(swing[:, None], time_s, 0.003) == pytest.approx((low_hz, high_hz), rel=0.05)
