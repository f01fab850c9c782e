"""Flicker noise seen in a strength, and what it does to a fit, against drawn noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from calib import get
from calib.numerics.flicker import LOWEST_HZ, flicker_covariance, flicker_power
from tests.calib.flickering import flicker
from tests.nightly import first_daily


def seen(n: int, seed: int, noise: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What a strength sees of noise (n, 3) along a slow tumble: r (n,) and a (n, 3)."""
    t = np.arange(n) / 10.0 + seed
    a = np.column_stack([np.sin(0.11 * t) * np.cos(0.05 * t), np.cos(0.11 * t), np.sin(0.11 * t) * np.sin(0.05 * t)])
    return np.einsum("ni,ni->n", a, noise), a


@pytest.mark.parametrize("density", [3.0, 6.0])
def test_power_is_that_of_the_noise_whatever_constant_is_taken_off(density):
    found = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        noise = 10.0 * rng.standard_normal((3600, 3)) + density * flicker(3600, rng)
        found.append(flicker_power(*seen(3600, seed, noise - noise.mean(axis=0)))[0])
    scatter = np.std(found) / np.sqrt(len(found))
    assert np.mean(found) == pytest.approx(density**2, abs=4 * scatter)
    assert scatter < 0.15 * density**2


def test_white_and_passing_noise_are_not_taken_for_flicker():
    known = []
    for seed in range(200):
        white = np.random.default_rng(seed).standard_normal((3600, 3))
        known.append(flicker_power(*seen(3600, seed, white))[0])
    assert np.count_nonzero(known) <= 3


def test_short_recordings_say_nothing():
    drift = np.random.default_rng(0).standard_normal((190, 3)).cumsum(axis=0)
    assert flicker_power(*seen(190, 0, drift)) == (0.0, 0.0)


def test_covariance_is_that_of_drawn_noise():
    """A mean over time and a slope; the noise's first line stands for all from half its frequency on."""
    n, rate_hz = 500, 2 * 64 * 500 * LOWEST_HZ
    time = np.linspace(-1.0, 1.0, n)
    K = np.zeros((n, 2, 3))
    K[:, 0, 0] = 1.0 / n
    K[:, 1, 1] = time / np.sum(time**2)
    drawn = [np.einsum("npc,nc->p", K, flicker(n, np.random.default_rng(seed))) for seed in range(500)]
    expected = flicker_covariance(K, rate_hz)
    assert np.diag(np.cov(np.transpose(drawn))) == pytest.approx(np.diag(expected), rel=0.2)
    assert abs(expected[0, 1]) < 1e-9


@pytest.mark.parametrize(
    "name", first_daily(["ellipsoid", "ml_geometric", "vector_least_squares", "twostep", "gyro_ml"], 3)
)
def test_flicker_noise_is_in_the_claim(name, standard):
    runs = 8 if name == "gyro_ml" else 16
    distances = []
    for seed in range(runs):
        white = standard.recording("full", seed)
        rng = np.random.default_rng([seed, 1])
        mag_nT = white.mag_nT + flicker(len(white), rng) * [5.0, 5.0, 8.0]
        rate_rad_s = white.gyro_rad_s + 1e-3 * rng.standard_normal(white.gyro_rad_s.shape)
        fit = get(name).fit(replace(white, mag_nT=mag_nT, gyro_rad_s=rate_rad_s), standard.REFERENCE)
        distances.append((fit.offset_nT - standard.HARD_NT) / np.sqrt(np.diag(fit.offset_covariance_nT2)))
    assert 0.55 < np.sqrt(np.mean(np.square(distances))) < 1.4
