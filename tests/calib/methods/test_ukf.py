"""The unscented filter: at the bound where the strength suffices, honest where it does not."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import approx_fprime

from calib import get
from calib.methods.ukf import UkfCalibrator, correction, ellipsoid_fit, spread
from calib.numerics.unscented import half_square


def test_block_is_spread_over_the_whole_recording():
    blocks = spread(np.arange(30.0).reshape(10, 3), 2)
    assert blocks.shape == (5, 2, 3)
    np.testing.assert_array_equal(blocks[0], [[0, 1, 2], [15, 16, 17]])


def test_observation_is_half_the_squared_strength():
    state = np.array([0.1, -0.2, 0.05, 0.02, 0.01, -0.03, 0.04, 0.015, -0.02])
    h = np.random.default_rng(0).normal(size=(50, 3))
    h /= np.linalg.norm(h, axis=1)[:, None]
    S = np.linalg.inv(correction(state))
    np.testing.assert_allclose(half_square(state, (h + state[:3]) @ S), 0.5, rtol=1e-12)


def test_claimed_covariance_follows_from_the_states():
    state = np.array([0.1, -0.2, 0.05, 0.02, 0.01, -0.03, 0.04, 0.015, -0.02])

    def values(x):
        S = np.linalg.inv(correction(x))
        return np.concatenate((S @ x[:3], S[np.triu_indices(3)]))

    jacobian = approx_fprime(state, values, 1e-7)
    fit = ellipsoid_fit(state, np.eye(9), 1.0, ())
    np.testing.assert_allclose(fit.covariance, jacobian @ jacobian.T, rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize(("motion", "bound_nT"), [("full", 0.5592), ("pitch", 7.589)])
def test_near_the_bound_and_sure_of_the_right_amount(motion, bound_nT, standard):
    fits = [get("ukf").fit(standard.recording(motion, seed), standard.REFERENCE) for seed in range(6)]
    assert all(fit.status.kind == "ok" for fit in fits)
    errors = np.array([fit.offset_nT - standard.HARD_NT for fit in fits])
    assert np.sqrt((errors**2).sum(axis=1).mean()) < 1.6 * bound_nT
    chi2 = sum(e @ np.linalg.solve(fit.offset_covariance_nT2, e) for e, fit in zip(errors, fits, strict=True))
    # 18 degrees of freedom
    assert 5 < chi2 < 45


def test_never_sure_and_wrong_on_the_auv_motion(standard):
    for seed in range(8):
        fit = get("ukf").fit(standard.recording("auv", seed), standard.REFERENCE)
        std_nT = np.sqrt(np.diag(fit.offset_covariance_nT2)) if fit.covariance is not None else np.zeros(3)
        assert fit.status.kind != "ok" or (np.abs(fit.offset_nT - standard.HARD_NT) < 4 * std_nT).all()
        assert fit.status.reason


def test_noise_is_told(standard):
    fit = get("ukf").fit(standard.recording("full", 1, noise_std_nT=40.0), standard.REFERENCE)
    assert fit.parameters["noise_std_nT"] == pytest.approx(40.0, rel=0.1)


def test_a_block_longer_than_the_recording_is_named(standard):
    status = UkfCalibrator(block=101).fit(standard.recording("full", 0, n=100), standard.REFERENCE).status
    assert status.kind == "not_applicable"
    assert "smaller block" in status.reason
