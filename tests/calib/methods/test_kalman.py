"""The Kalman family: filter against batch least squares, claims against errors, adaptation against known noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from calib.families.vector_filter import KalmanSettings, innovation_ratio, track
from calib.methods.kalman import KalmanCalibrator
from calib.methods.kalman_fuzzy import KalmanFuzzyCalibrator
from calib.methods.kalman_rescaled import MICROTESLA, KalmanRescaledCalibrator
from calib.methods.vector_least_squares import VectorLeastSquares
from calib.models.vector import IDENTITY, NAMES, VectorData
from calib.numerics.fuzzy import GRID, RULES, MamdaniRatio

EDDY_S = np.array([[0.1, 0.32, 0.22], [0.13, 0.16, 0.61], [0.16, 0.17, 0.02]])
CONSTANT = replace(MICROTESLA, state_variance=0.0, noise_variance_nT2=100.0)
"""Constant iron, and the true noise of the standard case."""
FORGETFUL = replace(MICROTESLA, state_variance=1.0)
MILD = KalmanSettings(1000.0, prior_variance=1e-2, state_variance=1e-10, noise_variance_nT2=100.0)
"""A prior that leaves digits: where P H H^T / R is 1e14, as in [Li2017], rounding alone moves T_p by 1e-8 of it."""


def true_values(standard, eddy_s):
    return np.concatenate((standard.HARD_NT, standard.SOFT.ravel(), eddy_s.ravel()))


def test_model_predicts_the_measurement_exactly(standard):
    recording = standard.recording("full", None, eddy_s=EDDY_S)
    data = VectorData.of(recording, standard.REFERENCE)
    for unit in (1.0, 1000.0):
        state = true_values(standard, EDDY_S) - IDENTITY
        state[:3] /= unit
        np.testing.assert_allclose(data.observation(unit) @ state, data.difference_nT, atol=1e-6)


def test_without_a_gyro_the_attitude_gives_the_rate(standard):
    recording = standard.recording("full", None)
    with_gyro = VectorData.of(recording, standard.REFERENCE)
    without = VectorData.of(replace(recording, gyro_rad_s=None), standard.REFERENCE)
    error = (without.rate_nT_s - with_gyro.rate_nT_s)[1:-1]
    assert np.abs(error).max() < 2e-3 * np.abs(with_gyro.rate_nT_s).max()


def test_filter_of_a_constant_state_is_regularised_least_squares(standard):
    data = VectorData.of(standard.recording("full", 0, n=400, eddy_s=EDDY_S), standard.REFERENCE)
    steps = track(data, CONSTANT)
    start = np.concatenate((np.zeros(3), np.full(9, 0.01), np.full(9, 0.02)))
    H, y = data.observation(1000.0).reshape(-1, 21), data.difference_nT.ravel()
    information = np.eye(21) / CONSTANT.prior_variance + H.T @ H / CONSTANT.noise_variance_nT2
    unit = np.array([1000.0] * 3 + [1.0] * 18)
    expected = start + np.linalg.solve(information, H.T @ (y - H @ start) / CONSTANT.noise_variance_nT2)
    claimed = np.linalg.inv(information) * np.outer(unit, unit)
    std = np.sqrt(np.diag(claimed))
    assert np.abs((steps.state[-1] - unit * expected) / std).max() < 1e-3
    np.testing.assert_allclose(steps.covariance / np.outer(std, std), claimed / np.outer(std, std), atol=1e-4)
    assert steps.variance_factor == pytest.approx(1.0, abs=0.1)


def test_constant_iron_reaches_least_squares(standard):
    recording = standard.recording("auv", 1, eddy_s=EDDY_S)
    one = KalmanRescaledCalibrator(settings=CONSTANT).fit(recording, standard.REFERENCE)
    other = VectorLeastSquares(eddy=True).fit(recording, standard.REFERENCE)
    assert one.status.kind == other.status.kind == "ok"
    np.testing.assert_allclose(one.offset_nT, other.offset_nT, atol=0.1)
    np.testing.assert_allclose(one.eddy_s, other.eddy_s, atol=1e-4)


@pytest.mark.parametrize("assumed_nT2", [1.0, 100.0, 1e4])
def test_claims_match_errors_whatever_noise_is_assumed(assumed_nT2, standard):
    calibrator = KalmanRescaledCalibrator(settings=replace(CONSTANT, noise_variance_nT2=assumed_nT2))
    truth = true_values(standard, np.zeros((3, 3)))
    squares = []
    for seed in range(6):
        fit = calibrator.fit(standard.recording("pitch", seed, n=1200), standard.REFERENCE)
        assert fit.status.kind == "ok"
        error = np.array([fit.parameters[name] for name in NAMES]) - truth
        squares.append(error @ np.linalg.solve(fit.covariance, error))
    # chi-squared with 21 degrees of freedom, six times: 126 +- 16
    assert 70 < sum(squares) < 190


def test_rounding_does_not_break_a_filter_that_trusts_its_sensor(standard):
    settings = replace(MICROTESLA, state_variance=0.0)
    fit = KalmanRescaledCalibrator(settings).fit(standard.recording("auv", 1), standard.REFERENCE)
    np.testing.assert_allclose(fit.offset_nT, standard.HARD_NT, atol=30.0)
    assert np.linalg.eigvalsh(fit.covariance).min() >= 0


def test_the_papers_original_scaling_says_that_it_has_not_converged(standard):
    fit = KalmanCalibrator().fit(standard.recording("full", 1), standard.REFERENCE)
    assert fit.status.kind == "not_converged"
    assert "offset_" in fit.status.reason
    assert "use kalman_rescaled" in fit.status.reason
    assert np.abs(fit.offset_nT).max() < 0.01 * np.abs(standard.HARD_NT).max()


@pytest.mark.parametrize("calibrator", [KalmanRescaledCalibrator(), KalmanFuzzyCalibrator()])
def test_the_papers_settings_on_the_standard_motions(calibrator, standard):
    for motion, usable, limit in (("full", True, 5.0), ("pitch", True, 15.0), ("auv", False, 1000.0)):
        fit = calibrator.fit(standard.recording(motion, 3), standard.REFERENCE)
        assert (fit.status.kind == "ok") == usable
        error = fit.offset_nT - standard.HARD_NT
        assert np.abs(error).max() < limit
        assert (np.abs(error) < 4 * np.sqrt(np.diag(fit.offset_covariance_nT2))).all()


@pytest.mark.parametrize(
    ("calibrator", "advice"),
    [
        (
            KalmanRescaledCalibrator(FORGETFUL),
            "lower state_variance (0 for iron that stays), or use vector_least_squares",
        ),
        (KalmanFuzzyCalibrator(FORGETFUL), "lower state_variance"),
        (
            KalmanRescaledCalibrator(replace(CONSTANT, prior_variance=1e-7)),
            "turn about more axes, or use vector_least_squares",
        ),
    ],
)
def test_a_filter_that_has_not_converged_does_not_advise_itself(calibrator, advice, standard):
    status = calibrator.fit(standard.recording("full", 3), standard.REFERENCE).status
    told = advice in status.reason or "raise noise_variance_nT2" in status.reason  # how it ends is the processor's
    assert (status.kind, told) == ("not_converged", True), status.reason
    assert "use kalman" not in status.reason


def test_history_falls_to_the_final_share(standard):
    fit = KalmanRescaledCalibrator().fit(standard.recording("full", 1), standard.REFERENCE)
    assert len(fit.history) == 200
    assert fit.history[0] > 0.9 > 0.01 > fit.history[-1]


def test_rules_are_balanced_and_bounded():
    ratio = np.linspace(0.0, 5.0, 501)
    s = RULES.factor(ratio)
    assert (np.diff(s) > -1e-12).all()
    assert RULES.factor(np.array([1.0]))[0] == pytest.approx(1.0)
    np.testing.assert_allclose(s[[0, -1]], [1 - RULES.gain, 1 + RULES.gain], atol=1e-6)
    np.testing.assert_allclose(RULES.factor(2.0 - ratio[:201]), 2.0 - RULES.factor(ratio[:201]), atol=1e-9)


def test_rules_by_hand():
    # Half equal, half large: two triangles cut at a half, united; the centre is half way between the peaks.
    rules = MamdaniRatio(width=0.5, gain=0.2)
    small, equal, large = rules.memberships(np.array([1.25]))
    assert (small[0], equal[0], large[0]) == (0.0, 0.5, 0.5)
    assert rules.factor(np.array([1.25]))[0] == pytest.approx(1.1, abs=1e-3)
    assert len(rules.table()) == GRID


def test_ratio_is_one_where_the_prediction_holds():
    rng = np.random.default_rng(0)
    ratio = innovation_ratio(rng.normal(0, 3.0, (5000, 3)), np.full(5000, 27.0), 50)
    assert np.isnan(ratio[:49]).all()
    assert np.mean(ratio[49:]) == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("noise_std_nT", [3.0, 30.0])
def test_noise_is_learnt_where_the_state_is_nearly_constant(noise_std_nT, standard):
    recording = standard.recording("full", 1, noise_std_nT=noise_std_nT)
    calibrator = KalmanFuzzyCalibrator(replace(MICROTESLA, state_variance=1e-10))
    fit = calibrator.fit(recording, standard.REFERENCE)
    assert fit.parameters["noise_variance_nT2"] == pytest.approx(noise_std_nT**2, rel=0.5)
    assert fit.status.kind == "ok"


def test_noise_collapses_to_its_floor_where_the_state_variance_rules(standard):
    settings = replace(MICROTESLA, noise_variance_nT2=100.0)
    recording = standard.recording("full", 1, n=800)
    fit = KalmanFuzzyCalibrator(settings, floor_nT2=1e-3).fit(recording, standard.REFERENCE)
    assert fit.parameters["noise_variance_nT2"] == pytest.approx(1e-3)
    plain = KalmanRescaledCalibrator(settings).fit(recording, standard.REFERENCE)
    assert np.abs(fit.offset_nT - plain.offset_nT).max() < 10.0


def test_a_filter_that_broke_down_says_so(standard):
    calibrator = KalmanFuzzyCalibrator(replace(MICROTESLA, state_variance=0.0), rules=MamdaniRatio(gain=0.2))
    fit = calibrator.fit(standard.recording("full", 1, noise_std_nT=30.0), standard.REFERENCE)
    assert fit.status.kind in ("not_converged", "unobservable")


def test_adaptation_follows_noise_that_grows(standard):
    clean = standard.recording("full", None)
    quiet, loud = standard.noisy(clean, 1, 3.0).mag_nT[:1800], standard.noisy(clean, 2, 60.0).mag_nT[1800:]
    recording = replace(clean, mag_nT=np.concatenate((quiet, loud)))
    data = VectorData.of(recording, standard.REFERENCE)
    settings = KalmanSettings(1000.0, state_variance=1e-10, noise_variance_nT2=9.0)
    steps = track(data, settings, rule=KalmanFuzzyCalibrator(settings).noise_rule())
    assert np.median(steps.noise_variance_nT2[900:1800]) == pytest.approx(9.0, rel=0.5)
    assert np.median(steps.noise_variance_nT2[2700:]) == pytest.approx(3600.0, rel=0.5)


@pytest.mark.parametrize("calibrator", [KalmanRescaledCalibrator(MILD), KalmanFuzzyCalibrator(MILD)])
def test_engines_agree(calibrator, standard):
    recording = standard.recording("full", 1, n=600)
    ours, filterpys = (
        replace(calibrator, engine=engine).fit(recording, standard.REFERENCE) for engine in ("compiled", "filterpy")
    )
    np.testing.assert_allclose(ours.offset_nT, filterpys.offset_nT, rtol=1e-10)
    np.testing.assert_allclose(ours.matrix, filterpys.matrix, atol=1e-10)
    std = np.sqrt(np.diag(filterpys.covariance))
    unit = np.outer(std, std)
    np.testing.assert_allclose(ours.covariance / unit, filterpys.covariance / unit, atol=1e-8)
