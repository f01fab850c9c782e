"""Maximum likelihood along the gyro: bound, interval, starts, what the gyro may be wrong in."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib.methods.gyro_ml import GyroMl

BOUND_NT = {"full": 0.556, "pitch": 6.75, "auv": 68.5}
"""The standard case: strength and gyro, its bias not known."""
GYRO_RAD_S, BIAS_RAD_S = 1e-3, np.array([0.004, -0.002, 0.003])


def recorded(standard, motion, seed, *, gyro_rad_s=GYRO_RAD_S, bias_rad_s=BIAS_RAD_S, soft=None):
    """The standard case with a noisy gyro."""
    measured = standard.recording(motion, seed, soft=standard.SOFT if soft is None else soft)
    noise_rad_s = np.random.default_rng([seed, 1]).normal(0, gyro_rad_s, measured.gyro_rad_s.shape)
    return replace(measured, gyro_rad_s=measured.gyro_rad_s + bias_rad_s + noise_rad_s)


def fits(standard, motion, seeds):
    return [GyroMl().fit(recorded(standard, motion, seed), standard.REFERENCE) for seed in seeds]


def normalised(fit, standard):
    """Errors of offset, S and bias in claimed standard deviations (15,)."""
    truth = np.concatenate((standard.HARD_NT, standard.SOFT.ravel(), BIAS_RAD_S))
    found = np.array([fit.parameters[name] for name in fit.covariance_names])
    return (found - truth) / np.sqrt(np.diag(fit.covariance))


def rms_nT(results, standard):
    return np.sqrt(np.mean([np.sum((r.offset_nT - standard.HARD_NT) ** 2) for r in results]))


@pytest.mark.parametrize(
    ("motion", "count"), [("full", 5), ("pitch", 5), pytest.param("auv", 10, marks=pytest.mark.slow)]
)
def test_hard_iron_reaches_the_bound_and_all_is_claimed_so(motion, count, standard):
    results = fits(standard, motion, range(count))
    assert {r.status.kind for r in results} == {"ok"}
    assert rms_nT(results, standard) < 1.6 * BOUND_NT[motion]
    claimed_nT = np.sqrt(np.mean([np.trace(r.offset_covariance_nT2) for r in results]))
    assert claimed_nT == pytest.approx(BOUND_NT[motion], rel=0.1)
    errors = np.array([normalised(r, standard) for r in results])
    # the 15 are correlated: some five free ones a run, so that the mean square scatters by 0.2 and less
    assert 0.4 < np.mean(errors**2) < 1.8
    for told, truth in (("noise_std_nT", 10.0), ("gyro_noise_std_rad_s", GYRO_RAD_S)):
        assert np.mean([r.parameters[told] for r in results]) == pytest.approx(truth, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("motion", list(BOUND_NT))
def test_a_thousand_runs_reach_the_bound_and_are_covered(motion, standard):
    results = fits(standard, motion, range(1000))
    assert {r.status.kind for r in results} == {"ok"}
    assert rms_nT(results, standard) <= 1.15 * BOUND_NT[motion]
    inside = np.abs([normalised(r, standard) for r in results]) < 1.96
    assert 0.93 < inside[:, :3].mean() < 0.97
    assert 0.93 < inside.mean() < 0.97


@pytest.mark.parametrize("motion", ["pitch", "auv"])
def test_strong_iron_and_a_large_bias_need_no_luck(motion, standard):
    """Axes stretched by up to half, an offset of many fields, a bias as fast as the vehicle's own turns."""
    soft = standard.SOFT @ np.array([[1.3, 0.2, -0.1], [0.2, 0.8, 0.15], [-0.1, 0.15, 1.1]])
    recording = recorded(standard, motion, 1, soft=soft, bias_rad_s=np.array([0.05, -0.08, 0.06]))
    far_nT = np.array([2e5, -3e5, 1e5])
    fit = GyroMl().fit(replace(recording, mag_nT=recording.mag_nT + far_nT), standard.REFERENCE)
    assert fit.status.kind == "ok"
    error_nT = fit.offset_nT - standard.HARD_NT - far_nT
    assert error_nT @ np.linalg.solve(fit.offset_covariance_nT2, error_nT) < 25


def test_gyro_that_is_mounted_askew_is_found_so(standard):
    recording = recorded(standard, "pitch", 2)
    turn = Rotation.from_rotvec([0.03, -0.05, 0.08])
    fit = GyroMl().fit(replace(recording, gyro_rad_s=turn.apply(recording.gyro_rad_s)), standard.REFERENCE)
    straight = GyroMl().fit(recording, standard.REFERENCE)
    np.testing.assert_allclose(fit.offset_nT, straight.offset_nT, atol=1.0)
    np.testing.assert_allclose(fit.matrix, turn.as_matrix() @ straight.matrix, atol=1e-3)
    taken = GyroMl(aligned=True).fit(recording, standard.REFERENCE)
    assert taken.status.kind == "ok"
    np.testing.assert_allclose(taken.matrix, taken.matrix.T, atol=1e-12)
    error_nT = taken.offset_nT - standard.HARD_NT
    assert error_nT @ np.linalg.solve(taken.offset_covariance_nT2, error_nT) < 20


def test_axes_of_another_frame_are_told(standard):
    recording = recorded(standard, "auv", 3)
    fit = GyroMl().fit(replace(recording, gyro_rad_s=recording.gyro_rad_s @ standard.FLIP), standard.REFERENCE)
    assert fit.status.kind == "ok"
    assert "turned by 180 degrees" in fit.status.reason


def test_gyro_that_says_nothing_leaves_what_the_strength_says(standard):
    """Rates of another motion: their noise is found as large as they are, and the claim is that without a gyro."""
    recording = recorded(standard, "full", 4)
    other = np.random.default_rng(0).permutation(recording.gyro_rad_s)
    fit = GyroMl(aligned=True).fit(replace(recording, gyro_rad_s=other), standard.REFERENCE)
    assert fit.parameters["gyro_noise_std_rad_s"] > 0.1
    error_nT = fit.offset_nT - standard.HARD_NT
    assert np.linalg.norm(error_nT) < 3
    assert np.sqrt(np.trace(fit.offset_covariance_nT2)) == pytest.approx(0.56, rel=0.05)


def test_noise_that_is_stated_is_kept(standard):
    recording = recorded(standard, "pitch", 5)
    stated = GyroMl(gyro_std_rad_s=2e-3).fit(recording, standard.REFERENCE)
    assert stated.parameters["gyro_noise_std_rad_s"] == pytest.approx(2e-3, rel=0.02)


def test_samples_lost_and_out_of_order_are_no_harm(standard):
    recording = recorded(standard, "pitch", 6)
    kept = np.random.default_rng(0).permutation(np.flatnonzero(np.arange(3600) % 900 < 700))
    lost = replace(
        recording,
        **{name: getattr(recording, name)[kept] for name in ("time_s", "mag_nT", "gyro_rad_s", "att_q")},
    )
    fit = GyroMl().fit(lost, standard.REFERENCE)
    assert fit.status.kind == "ok"
    assert np.abs(normalised(fit, standard)).max() < 4.5
