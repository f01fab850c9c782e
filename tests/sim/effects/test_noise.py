"""Statistics of the random effects of the sensor, against their theory and the Allan deviation."""

from __future__ import annotations

from dataclasses import replace

import allantools
import numpy as np
import pytest
from scipy.signal import welch

from sim.effects.noise import FlickerNoise, WhiteNoise, flicker_bank
from sim.effects.offsets import OffsetRandomWalk


def sample(effect, states, n, interval_s=0.02, seed=1):
    state = replace(states(2, interval_s), time_s=np.arange(n) * interval_s)
    return effect.apply(state, np.zeros((n, 3)), np.random.default_rng(seed), {})


def allan_slope(series, rate, taus):
    used, deviation, _, _ = allantools.oadev(series, rate=rate, data_type="freq", taus=taus)
    return np.polyfit(np.log(used), np.log(deviation), 1)[0], deviation


def test_white_noise_has_its_deviation_no_correlation_and_slope_minus_half(states):
    n = 200_000
    label = sample(WhiteNoise((5, 1, 0)), states, n)
    assert label[:, 0].std() == pytest.approx(5, rel=4 / np.sqrt(2 * n))
    assert label[:, 1].std() == pytest.approx(1, rel=4 / np.sqrt(2 * n))
    assert not label[:, 2].any()
    assert abs(np.corrcoef(label[1:, 0], label[:-1, 0])[0, 1]) < 4 / np.sqrt(n)
    assert abs(np.corrcoef(label[:, 0], label[:, 1])[0, 1]) < 4 / np.sqrt(n)
    slope, deviation = allan_slope(label[:, 0], 50, [0.02, 0.1, 0.5, 2, 10])
    assert slope == pytest.approx(-0.5, abs=0.03)
    assert deviation[0] == pytest.approx(5, rel=0.02)


def test_random_walk_grows_with_the_root_of_time_and_has_slope_plus_half(states):
    label = sample(OffsetRandomWalk(2.0), states, 200_000)
    assert not label[0].any()
    steps = np.diff(label, axis=0)
    assert steps.std() == pytest.approx(2 * np.sqrt(0.02), rel=0.01)
    slope, deviation = allan_slope(label[:, 0], 50, [1, 2, 5, 10, 20, 50])
    assert slope == pytest.approx(0.5, abs=0.06)
    assert deviation[0] == pytest.approx(2 * np.sqrt(1 / 3), rel=0.05)


@pytest.mark.parametrize("interval_s", [0.02, 0.1, 1.0])
def test_the_flicker_banks_density_is_one_over_f_in_its_whole_band(interval_s):
    decay, std = flicker_bank(interval_s)
    f = np.geomspace(2e-5, 0.45 / interval_s, 300)
    turn = np.cos(2 * np.pi * f * interval_s)[:, None]
    parts = std**2 * 2 * interval_s * (1 - decay**2) / (1 - 2 * decay * turn + decay**2)
    density = parts.sum(axis=1) * (1.04 + 0.4 * turn[:, 0]) / 1.44
    assert np.abs(density * f - 1).max() < 0.03


def test_flicker_noise_has_its_level_and_slope(states):
    label = sample(FlickerNoise((3, 1, 0)), states, 400_000)
    f, density = welch(label[:, 0], 50, nperseg=40_000)
    band = (f > 0.005) & (f < 20)
    slope, _ = np.polyfit(np.log(f[band]), np.log(density[band]), 1, w=np.sqrt(1 / f[band]))
    assert slope == pytest.approx(-1, abs=0.03)
    f, density = welch(label[:, 0], 50, nperseg=4_000)
    band = (f > 0.1) & (f < 20)
    assert np.mean(density[band] * f[band]) == pytest.approx(9, rel=0.03)
    assert not label[:, 2].any()


def test_the_allan_deviation_of_flicker_noise_is_flat_at_its_level(states):
    label = sample(FlickerNoise(1.0), states, 400_000)
    taus = [0.5, 1, 2, 5, 10, 20]
    deviations = np.mean([allan_slope(label[:, j], 50, taus)[1] for j in range(3)], axis=0)
    np.testing.assert_allclose(deviations, np.sqrt(2 * np.log(2)), rtol=0.06)


def test_flicker_noise_is_stationary_from_the_first_sample(states):
    first, last = [], []
    for seed in range(300):
        label = sample(FlickerNoise(1.0), states, 40, seed=seed)
        first.append(label[0])
        last.append(label[-1])
    variance = sum(flicker_bank(0.02)[1] ** 2)
    for values in (first, last):
        assert np.var(values) == pytest.approx(variance, rel=4 * np.sqrt(2 / 900))
