"""The accelerometer beside the gyro: what it gains at rest, and that it does no harm where the vehicle accelerates."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib.methods.gyro_accel_ml import GyroAccelMl, lasting
from calib.methods.gyro_ml import GyroMl
from tests.calib.methods.test_gyro_ml import recorded
from tests.validation.bound.experiments import ACCEL_STD_M_S2, of_motion
from validation.bound.bound import Bound

BIAS_M_S2 = np.array([0.03, -0.05, 0.02])


def levelled(standard, motion, seed, vehicle_m_s2=0.0):
    """The standard case with a noisy gyro and accelerometer, and accelerations of the vehicle in the world, (n, 3)."""
    one = recorded(standard, motion, seed)
    noise_m_s2 = np.random.default_rng([seed, 2]).normal(0.0, ACCEL_STD_M_S2, one.mag_nT.shape)
    own_m_s2 = Rotation.from_quat(one.att_q, scalar_first=True).inv().apply(vehicle_m_s2 + np.zeros_like(one.mag_nT))
    still = standard.with_accelerometer(one)
    return replace(still, accel_m_s2=still.accel_m_s2 + own_m_s2 + BIAS_M_S2 + noise_m_s2)


def errors_nT(fits, standard):
    return np.array([fit.offset_nT - standard.HARD_NT for fit in fits])


def rms(errors):
    return np.sqrt(np.mean(np.sum(errors**2, axis=1)))


def test_a_level_vehicle_gains_and_reaches_the_bound(standard):
    """Claimed is the bound, which counts a symmetric S; three errors scatter about what is claimed."""
    bound_nT = Bound.of(of_motion("auv"), "norm+gyro+accel").offset_rms_nT
    fits = [GyroAccelMl().fit(levelled(standard, "auv", seed), standard.REFERENCE) for seed in range(3)]
    assert {fit.status.kind for fit in fits} == {"ok"}
    claimed_nT = np.sqrt(np.mean([np.trace(fit.offset_covariance_nT2) for fit in fits]))
    assert claimed_nT == pytest.approx(bound_nT, rel=0.1)
    assert claimed_nT < 0.85 * Bound.of(of_motion("auv"), "norm+gyro").offset_rms_nT
    assert rms(errors_nT(fits, standard)) < 1.8 * claimed_nT
    assert fits[0].parameters["accel_noise_std_m_s2"] == pytest.approx(ACCEL_STD_M_S2, rel=0.05)
    found = np.array([[fit.parameters[f"accel_bias_{axis}_m_s2"] for axis in "xy"] for fit in fits])
    np.testing.assert_allclose(found.mean(axis=0), BIAS_M_S2[:2], atol=0.015)


@cache
def without_accelerometer(standard):
    """Fits of the gyro alone, which no acceleration changes."""
    return [GyroMl().fit(levelled(standard, "pitch", seed), standard.REFERENCE) for seed in range(2)]


@pytest.mark.parametrize("period_s", [3.0, 40.0])
def test_a_vehicle_that_pushes_itself_about_comes_to_no_harm(period_s, standard):
    """Half a metre a second squared to and fro, 25 times the sensor's noise and not white: as good as without."""
    phase = 2 * np.pi * np.arange(3600) / 10.0 / period_s
    sway_m_s2 = 0.5 * np.column_stack([np.sin(phase), np.cos(phase), 0.3 * np.sin(2 * phase)])
    recordings = [levelled(standard, "pitch", seed, sway_m_s2) for seed in range(2)]
    with_it, without = (
        [GyroAccelMl().fit(one, standard.REFERENCE) for one in recordings],
        without_accelerometer(standard),
    )
    assert {fit.status.kind for fit in with_it} == {"ok"}
    assert rms(errors_nT(with_it, standard)) < 1.15 * rms(errors_nT(without, standard))
    assert with_it[0].parameters["accel_noise_std_m_s2"] > 0.3


def test_a_known_inclination_tells_more(standard):
    one = levelled(standard, "auv", 3)
    without, with_it = (
        GyroAccelMl(inclination_std_deg=std).fit(one, standard.REFERENCE).offset_covariance_nT2 for std in (None, 0.01)
    )
    assert np.trace(with_it) < 0.5 * np.trace(without)


def test_noise_that_lasts_counts_as_its_means_scatter():
    rng = np.random.default_rng(0)
    white = rng.normal(0.0, 2.0, (4000, 3))
    assert lasting(white) == pytest.approx(2.0, rel=0.03)
    # each value for twenty samples: means over blocks scatter as those of white noise of sqrt(20) times the size
    assert lasting(np.repeat(white[:200], 20, axis=0)) == pytest.approx(2.0 * np.sqrt(20), rel=0.15)
