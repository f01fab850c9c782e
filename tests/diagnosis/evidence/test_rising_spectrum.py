"""Noise that is white or falls with frequency shows no structure; a tone that sweeps does, where it sweeps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.evidence.residual_tests import RisingSpectrum, _limited
from diagnosis.policy import STANDARD, Policy
from scenarios.arrays import Array
from tests.diagnosis.synthetic import HZ, problem

N = 4000
T = np.arange(N) / HZ
SPEED_HZ = 2.5 + np.cos(2 * np.pi * T / 300)
SWEPT = 0.5 * np.sin(2 * np.pi * np.cumsum(SPEED_HZ) / HZ)[:, None]
LOOSE, LARGER = Policy(spectrum_alarm=0.2, hardly_any=1e-9), Policy(hardly_any=0.2)
POSED = {policy: problem(policy=policy) for policy in (STANDARD, LOOSE, LARGER)}


def _white(seed: int) -> Array:
    return np.random.default_rng([seed, 8]).normal(size=(N, 3))


def _far(seed: int) -> Array:
    """White noise whose first rows are far off, to and fro, and as strong as the noise of all."""
    return _white(seed) + np.where(np.arange(N) < 20, 20.0 * (-1.0) ** np.arange(N), 0.0)[:, None]


def _rise(left: Array, taken: Array | float = 0.0, policy: Policy = STANDARD) -> RisingSpectrum | None:
    return RisingSpectrum.of(POSED[policy], left + taken, left)


@pytest.mark.parametrize(
    ("loudness", "memory", "low", "high"),
    [(0.0, 0.0, 0.14, 0.26), (1.0, 0.0, 0.02, 0.26), (0.0, 0.5, 0.0, 0.02)],
)
def test_noise_shows_structure_as_often_as_is_stated(loudness: float, memory: float, low: float, high: float) -> None:
    """White noise as often; seldom one that is louder now and then, or whose spectrum falls."""
    loud = np.exp(loudness * np.sin(T / 60))[:, None]
    several = (loud * (w + memory * np.roll(w, 1, axis=0)) for w in map(_white, range(300)))
    assert low <= np.mean([_rise(one, policy=LOOSE) is not None for one in several]) <= high


def test_a_tone_that_sweeps_is_told_where_it_sweeps() -> None:
    found = _rise(_white(1) + SWEPT)
    assert found is not None
    assert (found.low_hz, found.high_hz) == pytest.approx((1.5, 3.5), rel=0.15)
    assert found.words == f"structure between {found.low_hz:.2g} and {found.high_hz:.2g} Hz"
    assert _rise(_white(1)) is None
    assert _rise(_white(1) + SWEPT, policy=LARGER) is None


def test_a_few_far_rows_are_no_structure_and_hide_none() -> None:
    """As at the beginning of a leg."""
    assert _rise(_far(2)) is None
    assert _rise(_far(2) + 2 * SWEPT) is not None


@pytest.mark.parametrize(
    ("taken", "hides"),
    [
        (0.1 * np.sin(2 * np.pi * 2.2 * T), True),
        (1.0 * np.sin(2 * np.pi * 2.2 * T), False),
        (0.1 * np.sin(2 * np.pi * 4.5 * T), False),
        (0.1 * T / T[-1], False),
        (0.1 * np.sin(2 * np.pi * 2.2 * T) + 0.05 * np.sin(2 * np.pi * 0.02 * T), True),
    ],
)
def test_it_hides_what_is_small_and_as_fast(taken: Array, hides: bool) -> None:
    """A small tone within the sweep is a part of it; one beside it, and a drift, stand by themselves."""
    found = _rise(_white(3) + SWEPT, taken[:, None])
    assert found is not None
    assert found.hides is hides


def test_what_rises_to_the_end_is_told_up_to_half_the_rate() -> None:
    found = _rise(np.diff(_white(4), axis=0, prepend=0.0))
    assert found is not None
    assert found.high_hz == pytest.approx(HZ / 2)


def test_samples_left_out_of_a_slow_course_and_a_rest_of_nothing_are_no_structure() -> None:
    """With noughts in their places a slow course would have the pattern's frequencies."""
    usable = np.where(np.arange(N) % 3 == 0, 0.0, 1.0)
    left = _white(5) + 5 * np.sin(T / 40)[:, None]
    assert (
        RisingSpectrum.of(replace(POSED[STANDARD], usable=usable), left * usable[:, None], left * usable[:, None])
        is None
    )
    assert _rise(np.zeros((N, 3))) is None


def test_squares_that_are_more_even_than_normal_ones_are_no_evidence() -> None:
    """Of noise that is plus or minus one the spectrum is as uneven as of any."""
    assert _limited(np.sign(_white(6)), STANDARD)[1] == 1.0


def test_far_rows_beside_a_constant_are_limited() -> None:
    limited, _ = _limited(100.0 + _far(7), STANDARD)
    assert np.abs(limited).max() < 6.0


@pytest.mark.parametrize("stated", [True, False])
def test_errors_of_the_attitude_as_stated_are_as_fast_as_the_motion(stated: bool) -> None:
    posed = POSED[STANDARD]
    turned = np.cross(posed.direction, [0.5, -0.3, 0.4]) * 4 * SWEPT
    std_rad = 5.0 * float(posed.sigma_nT.max() / np.linalg.norm(posed.state.field_enu_nT)) if stated else 0.0
    left = _white(8) + turned
    found = RisingSpectrum.of(replace(posed, attitude_std_rad=std_rad), left, left)
    assert (found is None) is stated
