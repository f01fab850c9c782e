"""A field that changes in time is seen by the strength alone, and by strength and dip, at any attitude."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.policy import STANDARD
from diagnosis.problem.formulation import pose
from diagnosis.problem.known import Known, Level
from diagnosis.workflow import diagnose
from sim.effects.earth import DiurnalDrift
from sim.rotation import matrix_from_q
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import FIELD_ENU_NT, STRENGTH_NT, recording, without_attitude

ALONG = FIELD_ENU_NT / STRENGTH_NT
CHANGE = {"amplitude_enu_nT": [30.0, -80.0, 140.0], "period_s": 2000.0, "phase_deg": 30.0}


@pytest.mark.parametrize("by_dip", [False, True])
def test_the_attitude_of_the_problem_turns_the_measured_field_to_the_given_one(by_dip: bool) -> None:
    given = recording()
    level = Level.of(matrix_from_q(np.ascontiguousarray(given.att_q)), FIELD_ENU_NT, STANDARD) if by_dip else None
    state = pose(without_attitude(given), Known(FIELD_ENU_NT, STRENGTH_NT, level=level)).state
    turned = np.einsum("nij,nj->ni", state.R_wb, state.field_nT)
    assert np.allclose(np.linalg.det(state.R_wb), 1.0)
    assert np.allclose(turned / np.linalg.norm(turned, axis=1, keepdims=True), ALONG, atol=1e-9)
    if level is not None:
        assert np.allclose(np.einsum("nij,nj->ni", state.R_wb, level.down), [0.0, 0.0, -1.0], atol=0.01)


def test_it_is_named_with_its_part_along_the_field() -> None:
    given = without_attitude(recording(hidden={"diurnal_drift": CHANGE}))
    model = ModelSpec.model_validate({"field": {"enu_nT": FIELD_ENU_NT.tolist()}})
    found = diagnose(given, model, fitted_base=True)
    (cause,) = found.named
    assert isinstance(cause.effect, DiurnalDrift)
    told, t = cause.effect, given.time_s
    courses = [
        np.linalg.norm(a) * np.sin(2 * np.pi * t / p + np.radians(phase))
        for a, p, phase in (
            (told.amplitude_enu_nT, told.period_s, told.phase_deg),
            ([ALONG @ CHANGE["amplitude_enu_nT"]], CHANGE["period_s"], CHANGE["phase_deg"]),
        )
    ]
    told_course, true_course = (course - course.mean() for course in courses)
    assert abs(np.corrcoef(told_course, true_course)[0, 1]) > 0.99
    assert np.cross(told.amplitude_enu_nT, ALONG) == pytest.approx(
        0.0, abs=1e-6 * np.linalg.norm(told.amplitude_enu_nT)
    )


def test_one_that_the_model_states_is_no_gap() -> None:
    given = without_attitude(recording(hidden={"diurnal_drift": CHANGE}))
    model = ModelSpec.model_validate(
        {
            "field": {"enu_nT": FIELD_ENU_NT.tolist()},
            "effects": {"white_noise": {"std_nT": [2.0] * 3}, "diurnal_drift": CHANGE},
        }
    )
    assert diagnose(given, model).verdict == "none"
    assert diagnose(replace(given, mag_nT=recording().mag_nT), model).verdict != "none"
