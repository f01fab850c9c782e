"""A current that is switched is no noise once it is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.problem.formulation import pose_model
from diagnosis.workflow import diagnose
from sim.effects import of_sign
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import COSTLY, FIELD_ENU_NT, NOISE_NT, recording

GAIN_NT_A = np.array([8.0, -5.0, 6.0])
MODEL = ModelSpec.model_validate({"field": {"enu_nT": FIELD_ENU_NT.tolist()}})


def test_the_noise_is_that_beside_a_switched_current() -> None:
    given = recording(3000)
    on = 3.0 * (np.random.default_rng(1).random(3000) < 0.5)
    switched = replace(
        given, current_A=np.column_stack([on, np.zeros(3000)]), mag_nT=given.mag_nT + on[:, None] * GAIN_NT_A
    )
    assert pose_model(switched, MODEL, None, None).sigma_nT.min() > 3 * NOISE_NT
    found = diagnose(switched, MODEL, without=COSTLY)
    assert [cause.name for cause in found.named] == ["motor_current"]
    assert found.problem.sigma_nT == pytest.approx(NOISE_NT, rel=0.05)
    (white,) = (effect for effect in found.model.chain() if effect.name == of_sign("white", (1.0, 1.0, 1.0)).name)
    assert np.array(white.first_value) == pytest.approx(NOISE_NT, rel=0.05)
