"""Parameters beside coloured noise."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from diagnosis.repair.refinement import refine
from diagnosis.workflow import diagnose
from sim.effects import BY_NAME
from sim.effects.currents import MotorCurrent
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import COSTLY, FIELD_ENU_NT, NOISE_NT, problem, recording
from tests.nightly import first_daily

GAIN_NT_A = [4.0, -2.0, 8.0]
HIDDEN: dict[str, Any] = {
    "offset_random_walk": {"std_nT_sqrt_s": [1.0] * 3},
    "motor_current": {"gain_nT_A": GAIN_NT_A, "motor": 1},
}
MODEL = ModelSpec.model_validate(
    {"effects": {"white_noise": {"std_nT": [2.0] * 3}}, "field": {"enu_nT": FIELD_ENU_NT.tolist()}}
)


@pytest.mark.parametrize("seed", first_daily([0, 1, 2]))
def test_beside_a_random_walk_the_gain_is_the_motor_s_and_the_interval_holds(seed: int) -> None:
    """White least squares give 10 or -17 nT/A for 4, to within 3."""
    found = diagnose(recording(seed=seed, hidden=HIDDEN), MODEL, without=COSTLY)
    motor = next(cause for cause in found.named if cause.name == "motor_current")
    std = motor.spread["gain_nT_A"]
    assert std.max() < 0.5
    assert isinstance(motor.effect, MotorCurrent)
    assert np.abs((np.array(motor.effect.gain_nT_A) - GAIN_NT_A) / std).max() < 4.0


@pytest.mark.parametrize(("seed", "off_hz"), [(1, 1e-4), (2, 0.0)])
def test_the_phase_of_a_tone_of_unknown_frequency_is_known_half_as_well_at_the_start(seed: int, off_hz: float) -> None:
    """``2 s / (a sqrt(n / 2))``, also of numbers that are refined again, by steps too small to tell a slope."""
    n, amplitude_nT, tone = 6000, np.array([-0.83, -2.13, 1.5]), BY_NAME["steady_tone"]
    true = {"amplitude_nT": amplitude_nT.tolist(), "frequency_hz": 1.4415, "phase_deg": -10.0}
    posed = problem(recording(n, seed=seed, hidden={"steady_tone": true}))
    effects = (tone(amplitude_nT=tuple(1.02 * amplitude_nT), frequency_hz=1.4415 + off_hz, phase_deg=-8.0),)
    expected_deg = np.degrees(2 * NOISE_NT / (np.linalg.norm(amplitude_nT) * np.sqrt(n / 2)))
    for _ in range(2):
        effects, (spread,) = refine(posed, effects, np.ones(n, bool))
        assert spread["phase_deg"] == pytest.approx(expected_deg, rel=0.1)
