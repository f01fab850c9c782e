"""Noise that is white or falls with frequency shows no structure; a tone that sweeps does, where it sweeps."""

from __future__ import annotations

import numpy as np
import pytest

from sim.state import Array
from tests.validation.diagnosis.synthetic import HZ, problem
from validation.diagnosis.evidence.rising import Rise
from validation.diagnosis.policy import STANDARD, Policy

N = 4000
T = np.arange(N) / HZ
SPEED_HZ = 2.5 + np.cos(2 * np.pi * T / 300)
SWEPT = 0.5 * np.sin(2 * np.pi * np.cumsum(SPEED_HZ) / HZ)[:, None]
LOOSE, LARGER = Policy(rise_alarm=0.2, least_rise=1e-9), Policy(least_rise=0.2)
POSED = {policy: problem(policy=policy) for policy in (STANDARD, LOOSE, LARGER)}


def _white(seed: int) -> Array:
    return np.random.default_rng([seed, 8]).normal(size=(N, 3))


def _rise(left: Array, taken: Array | float = 0.0, policy: Policy = STANDARD) -> Rise | None:
    return Rise.of(POSED[policy], left + taken, left)


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
    """The first rows of a leg are far off, to and fro, and as strong as the noise of all."""
    far = np.where(np.arange(N) < 20, 20.0 * (-1.0) ** np.arange(N), 0.0)[:, None]
    assert _rise(_white(2) + far) is None
    assert _rise(_white(2) + far + 2 * SWEPT) is not None


@pytest.mark.parametrize(
    ("taken", "hides"),
    [
        (0.1 * np.sin(2 * np.pi * 2.2 * T), True),
        (1.0 * np.sin(2 * np.pi * 2.2 * T), False),
        (0.1 * np.sin(2 * np.pi * 4.5 * T), False),
        (0.1 * T / T[-1], False),
    ],
)
def test_it_hides_what_is_small_and_as_fast(taken: Array, hides: bool) -> None:
    """A small tone within the sweep is a part of it; one beside it, and a drift, stand by themselves."""
    found = _rise(_white(3) + SWEPT, taken[:, None])
    assert found is not None
    assert found.hides is hides
