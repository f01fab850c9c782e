"""The model that is written where the gap follows a channel, run by the simulator, leaves what is told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.workflow import diagnose
from sim.scenario import ModelSpec
from tests.diagnosis.conftest import BASE
from tests.diagnosis.synthetic import ALL_BUT_SEVEN, FIELD_ENU_NT, recording
from validation.signals.amplitude import rms

MODEL = ModelSpec.model_validate({"effects": BASE, "field": {"enu_nT": FIELD_ENU_NT.tolist()}})


def test_a_curve_and_the_iron_beside_it_leave_what_is_told() -> None:
    """The mean of the pump's field is iron beside the curve: without that iron the model leaves 8 nT."""
    given = recording(3000, hidden=BASE)
    course = np.sin(0.05 * given.time_s) + 0.5 * np.sin(0.13 * given.time_s)
    added_nT = np.outer(np.sign(course) * np.sqrt(np.abs(course)) + 1.0, [6.0, -4.0, 5.0])
    pumped = replace(given, mag_nT=given.mag_nT + added_nT, channels={"pump": course})
    found = diagnose(pumped, MODEL, without=ALL_BUT_SEVEN)
    assert [cause.effect.required_inputs[-1] for cause in found.named] == ["pump"]
    assert found.iron_anew
    assert found.resimulated_nT == pytest.approx(rms(found.after_nT[found.problem.usable > 0]), rel=0.05)
    assert found.sentence.endswith("nT.")
    assert "The new model has hard and soft iron fitted to this recording" in found.sentence
