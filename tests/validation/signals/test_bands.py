"""Bands of a spectrum: their level, their chance, and that they hold every line once."""

from __future__ import annotations

import numpy as np
import pytest

from validation.signals.bands import Bands, even_bands, hann


def test_bands_of_white_noise_have_its_level() -> None:
    """One-sided density of white noise of one unit: two intervals."""
    bands = Bands.of(np.random.default_rng(5).normal(size=(20_000, 3)), 0.1, 4, 40)
    assert bands.power[-10:] == pytest.approx([0.2] * 10, rel=0.15)
    level = bands.fit(np.zeros(len(bands.f)))[1]
    assert level == pytest.approx(0.2, rel=0.03)
    assert bands.chance(bands.power / 0.2) > 1e-4 * len(bands.f)


@pytest.mark.parametrize(("first", "last"), [(1, 40), (4, 5000)])
def test_bands_hold_every_line_once_and_widen(first: int, last: int) -> None:
    bands = even_bands(first, last, 30)
    assert [line for band in bands for line in range(band.start, band.stop)] == list(range(first, last))
    assert len(bands) < 30
    assert bands[-1].stop - bands[-1].start > bands[0].stop - bands[0].start


def test_the_window_begins_and_ends_near_zero_and_has_a_mean_square_of_three_eighths() -> None:
    assert hann(1000).shape == (1000, 1)
    assert hann(1000)[[0, -1]].max() < 1e-5
    assert (hann(1000) ** 2).mean() == pytest.approx(3 / 8)
