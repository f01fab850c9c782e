"""What remembers along uneven time: a delayed sine is a sine at other times, whatever the samples' moments."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scenarios.arrays import Array
from sim.effects.base import Replacement
from sim.effects.dynamics import Bandwidth, Latency
from sim.effects.resampling import UNEVEN
from sim.state import State

STEP_S, DELAY_S = 0.1, 0.013


def _wave(time_s: Array) -> Array:
    return 3e4 * np.stack([np.sin(0.7 * time_s), np.cos(0.4 * time_s), np.sin(0.9 * time_s)], axis=1)


def _apart(effect: Replacement, state: State, time_s: Array) -> float:
    """Rms of an effect less that of a pure delay, over the latter's."""
    given = replace(state, time_s=time_s, interval_s=STEP_S)
    found = effect.apply(given, _wave(time_s), np.random.default_rng(0), {})
    late = _wave(time_s - DELAY_S) - _wave(time_s)
    return float(np.linalg.norm((found - late)[3:]) / np.linalg.norm(late))


@pytest.mark.parametrize("effect", [Latency(DELAY_S), Bandwidth(1 / (2 * np.pi * DELAY_S))])
@pytest.mark.parametrize("spread", [0.0, 0.9 * UNEVEN, 0.3])
@pytest.mark.parametrize("gap_s", [0.0, 8.0])
def test_a_delay_is_one_at_uneven_times_and_across_gaps(
    states, effect: Replacement, spread: float, gap_s: float
) -> None:
    state = states(3000)
    time_s = STEP_S * (np.arange(3000) + np.random.default_rng(1).uniform(-spread, spread, 3000) / 2)
    time_s = time_s + gap_s * (time_s > 150) + gap_s * (time_s > 220)
    assert _apart(effect, state, time_s) < 0.06
