"""What comes and goes twice is one cause, told by its own times."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.workflow import diagnose
from sim.effects.iron import HardIron
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import FIELD_ENU_NT, recording

MODEL = ModelSpec.model_validate(
    {"effects": {"white_noise": {"std_nT": [2.0] * 3}}, "field": {"enu_nT": FIELD_ENU_NT.tolist()}}
)
PULSES_S = ((80.0, 90.0), (210.0, 220.0))


def test_two_short_pulses_are_one_magnet_at_their_own_times() -> None:
    """Beside the second pulse a current or a changed scale fits the first better than the magnet does."""
    given = recording(3000, seed=2)
    on = np.logical_or.reduce([(given.time_s >= a) & (given.time_s < b) for a, b in PULSES_S])
    found = diagnose(replace(given, mag_nT=given.mag_nT + np.outer(on, [12.0, -8.0, 6.0])), MODEL)
    (cause,) = found.named
    assert found.verdict.explained
    assert cause.name == HardIron.name
    windows = sorted(effect.active_s for effect in cause.effects if effect.active_s is not None)
    assert [end for window in windows for end in window] == pytest.approx(np.ravel(PULSES_S), abs=0.3)
