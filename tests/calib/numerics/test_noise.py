"""White noise of 5 nT within a few percent, whatever the motion, converter and faults: truth by simulation."""

from __future__ import annotations

import numpy as np
import pytest

from calib.numerics.noise import SECOND, clipped_mean, white_noise, white_noise_std
from scenarios.arrays import Array

SAMPLES, STD_NT, FIELD_NT = 12_000, 5.0, 48_000.0


def swinging(rate_deg_s: float, rate_hz: float) -> Array:
    """The field (n, 3) in a body that swings in heading with this greatest rate, pitching and rolling slower."""
    time_s = np.arange(SAMPLES) / rate_hz
    heading = np.radians(rate_deg_s) / 1.3 * np.sin(1.3 * time_s)
    pitch = 0.5 * np.sin(0.37 * np.radians(rate_deg_s) * time_s)
    level = np.cos(pitch)
    return FIELD_NT * np.column_stack([np.cos(heading) * level, np.sin(heading) * level, np.sin(pitch)])


def noise(seed: int, std_nT: float = STD_NT) -> Array:
    return np.random.default_rng(seed).normal(0, std_nT, (SAMPLES, 3))


@pytest.mark.parametrize("rate_hz", [20.0, 50.0, 100.0])
@pytest.mark.parametrize("rate_deg_s", [0.0, 10.0, 30.0, 100.0, 200.0])
def test_motion_does_not_enter(rate_deg_s: float, rate_hz: float) -> None:
    """Where plain second differences say up to 57 times the noise (200 deg/s at 20 Hz)."""
    found, settled = white_noise(swinging(rate_deg_s, rate_hz) + noise(1))
    np.testing.assert_allclose(found, STD_NT, rtol=0.05)
    assert settled.all()


def test_second_differences_alone_are_for_residuals() -> None:
    """At rest they say the same; of noise through a filter, v_i = (w_i + w_{i-1}) / 2, higher ones would say less."""
    np.testing.assert_allclose(white_noise_std(noise(2), orders=SECOND), STD_NT, rtol=0.05)
    filtered = (noise(2)[1:] + noise(2)[:-1]) / 2
    # D^2 of it: (1, -1, -1, 1) / 2 of the noise, so that its variance is 1/6 of the noise's
    np.testing.assert_allclose(white_noise_std(filtered, orders=SECOND), STD_NT / np.sqrt(6), rtol=0.05)
    assert (white_noise_std(filtered) < 0.9 * STD_NT / np.sqrt(6)).all()


def test_a_clipped_mean_says_the_same_of_a_residual_without_faults() -> None:
    """And a tenth more of one with spikes in half a percent of the samples: each counts as four sigma in three."""
    residual = noise(6)
    np.testing.assert_allclose(white_noise_std(residual, orders=SECOND, pooled=clipped_mean), STD_NT, rtol=0.03)
    residual[:: SAMPLES // 60] += 3000
    spiked = white_noise_std(residual, orders=SECOND, pooled=clipped_mean)
    np.testing.assert_allclose(spiked, STD_NT * np.sqrt(1 + 3 * 0.005 * 16), rtol=0.03)


@pytest.mark.parametrize("steps", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("std_nT", [0.5, 5.0, 50.0])
def test_rounding_adds_its_own_noise(std_nT: float, steps: float) -> None:
    """Rounding to steps of q: sigma^2 + q^2 / 12, in motion."""
    step = steps * std_nT
    values = step * np.round((swinging(30.0, 50.0) + noise(3, std_nT)) / step)
    np.testing.assert_allclose(white_noise_std(values), std_nT * np.sqrt(1 + steps**2 / 12), rtol=0.06)


def test_spikes_gaps_and_bursts_do_not_matter() -> None:
    rng = np.random.default_rng(0)
    values = swinging(30.0, 50.0) + noise(4)
    values[rng.choice(SAMPLES, 30, replace=False)] += 3000
    values[5000:5600] += rng.normal(0, 300, (600, 3))
    keep = np.r_[0:7000, 9000:SAMPLES]
    np.testing.assert_allclose(white_noise_std(values[keep], np.array([6999])), STD_NT, rtol=0.07)


def test_rows_that_are_held_are_told_by_their_new_values() -> None:
    """A slower sensor's value in three rows each: of the new ones the noise is right, of all it is not."""
    new = swinging(30.0, 20.0) + noise(5)
    held = np.repeat(new, 3, axis=0)
    np.testing.assert_allclose(white_noise_std(held[::3]), STD_NT, rtol=0.05)
    assert (np.abs(white_noise_std(held) / STD_NT - 1) > 0.3).all()


def test_axes_are_kept_apart() -> None:
    values = np.random.default_rng(1).normal(0, [1, 10, 100], (SAMPLES, 3))
    np.testing.assert_allclose(white_noise_std(values), [1, 10, 100], rtol=0.05)


def test_motion_that_no_difference_takes_out_is_no_noise() -> None:
    """A tone at a third of the sampling rate: 1 nT rms counts as noise of 1 nT times (2 sin(pi / 3))^p / sqrt(C)."""
    time = np.arange(SAMPLES)
    values = np.sqrt(2) * np.sin(2 * np.pi * time / 3)[:, None]
    np.testing.assert_allclose(white_noise_std(values, orders=SECOND), 3 / np.sqrt(6), rtol=0.02)


@pytest.mark.parametrize("samples", [0, 1, 3, 11])
def test_too_few_samples_give_no_noise(samples: int) -> None:
    found, settled = white_noise(np.zeros((samples, 3)))
    assert np.isnan(found).all()
    assert not settled.any()


def test_constant_values_have_no_noise() -> None:
    assert white_noise_std(np.ones((500, 2))).tolist() == [0.0, 0.0]
