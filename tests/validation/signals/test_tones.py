"""Lines of a spectrum: frequency within a bin, amplitude, and none in noise of any smooth colour."""

from __future__ import annotations

import numpy as np
import pytest

from tests.nightly import first_daily
from tests.validation.inspection.recordings import RATE_HZ
from validation.signals.tones import Tone, alias_hz, mains_aliases, mains_named, spectrum, tones

SAMPLES = 20_000
BIN_HZ = RATE_HZ / SAMPLES


def noise(seed: int, samples: int = SAMPLES, colour: float = 0.0) -> np.ndarray:
    """Noise (n, 3) of power density f^-colour, 5 nT."""
    white = np.random.default_rng(seed).normal(0, 5, (samples, 3))
    lines = np.fft.rfft(white, axis=0)
    frequency = np.maximum(np.arange(len(lines)), 1)[:, None]
    return np.fft.irfft(lines * frequency ** (-colour / 2), samples, axis=0)


@pytest.mark.parametrize("colour", first_daily([1.0, 0.0, 2.0]))
def test_noise_has_no_lines(colour: float) -> None:
    """False alarms: none in 100 recordings of each colour."""
    for seed in range(100):
        samples = int(np.random.default_rng(seed).integers(64, SAMPLES))
        assert tones(np.arange(samples) / RATE_HZ, noise(seed, samples, colour)) == []


def test_a_line_is_found_within_a_bin() -> None:
    time_s = np.arange(SAMPLES) / RATE_HZ
    for seed in range(20):
        frequency = np.random.default_rng(seed).uniform(0.5, 24.5)
        values = noise(seed) + np.array([0, 1.5, 0.7]) * np.sin(2 * np.pi * frequency * time_s + seed)[:, None]
        found = tones(time_s, values)
        assert len(found) == 1
        assert abs(found[0].frequency_hz - frequency) < 0.5 * BIN_HZ
        np.testing.assert_allclose(found[0].amplitude, [0, 1.5, 0.7], atol=0.25)


def test_a_line_between_the_spectrum_s_lines_loses_what_a_hann_window_loses() -> None:
    """Power (8 / 3 pi)^2 = 0.72 half way between two; without a window (2 / pi)^2 = 0.41."""
    time_s = np.arange(SAMPLES) / RATE_HZ
    on, between = (
        np.mean([tones(time_s, noise(seed) + 3 * np.sin(angle + seed)[:, None])[0].ratio for seed in range(5)])
        for angle in (2 * np.pi * line * BIN_HZ * time_s for line in (3000, 3000.5))
    )
    assert between / on == pytest.approx((8 / (3 * np.pi)) ** 2, rel=0.1)


def test_a_line_across_gaps_and_jitter() -> None:
    rng = np.random.default_rng(0)
    time_s = np.arange(SAMPLES) / RATE_HZ
    keep = np.r_[0:7000, 8000:15_000, 15_100:SAMPLES]
    time_s = time_s[keep] + rng.normal(0, 2e-4, len(keep))
    found = tones(time_s, noise(1)[keep] + 2 * np.sin(2 * np.pi * 7.3 * time_s)[:, None])
    assert abs(found[0].frequency_hz - 7.3) < BIN_HZ
    np.testing.assert_allclose(found[0].amplitude, 2, rtol=0.15)


def test_density_is_that_of_the_noise() -> None:
    found = spectrum(np.arange(SAMPLES) / RATE_HZ, noise(2))
    assert found is not None
    assert found.density.mean() == pytest.approx(2 * 25 / RATE_HZ, rel=0.03)
    np.testing.assert_allclose(found.background[500:-500], 2 * 25 / RATE_HZ, rtol=0.6)


@pytest.mark.parametrize("samples", [0, 1, 63])
def test_too_short_for_a_spectrum(samples: int) -> None:
    assert tones(np.arange(samples) / RATE_HZ, np.zeros((samples, 3))) == []


def test_constant_values_have_no_lines() -> None:
    assert tones(np.arange(500) / RATE_HZ, np.ones((500, 3))) == []


def test_aliases_of_the_mains() -> None:
    assert alias_hz(50.0, 120.0) == 50.0
    assert alias_hz(50.0, 40.0) == pytest.approx(10.0)
    assert mains_aliases(50.0)["50 Hz"] == 0.0
    tone = Tone(20.03, np.ones(3), 100.0, 0.0)
    assert mains_named(tone, 80.0, 0.01) == ("2 x 50 Hz", "60 Hz", "3 x 60 Hz")
    assert mains_named(tone, 53.0, 0.01) == ()
