"""Parameters beside coloured noise."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from diagnosis.workflow import diagnose
from sim.effects.currents import MotorCurrent
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import FIELD_ENU_NT, recording

GAIN_NT_A = [4.0, -2.0, 8.0]
HIDDEN: dict[str, Any] = {
    "offset_random_walk": {"std_nT_sqrt_s": [1.0] * 3},
    "motor_current": {"gain_nT_A": GAIN_NT_A, "motor": 1},
}
MODEL = ModelSpec.model_validate(
    {"effects": {"white_noise": {"std_nT": [2.0] * 3}}, "field": {"enu_nT": FIELD_ENU_NT.tolist()}}
)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_beside_a_random_walk_the_gain_is_the_motor_s_and_the_interval_holds(seed: int) -> None:
    """White least squares give 10 or -17 nT/A for 4, to within 3."""
    found = diagnose(recording(seed=seed, hidden=HIDDEN), MODEL)
    motor = next(cause for cause in found.named if cause.name == "motor_current")
    std = motor.spread["gain_nT_A"]
    assert std.max() < 0.5
    assert isinstance(motor.effect, MotorCurrent)
    assert np.abs((np.array(motor.effect.gain_nT_A) - GAIN_NT_A) / std).max() < 4.0
