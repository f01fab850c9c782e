"""What is said before a verdict where the stated strength is wrong."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from sim import effects as effect_table
from sim.scenario import ModelSpec
from tests.validation.diagnosis.synthetic import FIELD_ENU_NT, STRENGTH_NT, recording, without_attitude
from validation.diagnosis.decision.remarks import other_strength, turned_axes
from validation.diagnosis.problem.linear import LinearProblem
from validation.diagnosis.problem.pose import pose
from validation.diagnosis.result import Diagnosis
from validation.diagnosis.workflow import diagnose

IRON: dict[str, Any] = {
    "soft_iron": {"matrix": [[0.03, 0.02, -0.01], [0.01, -0.03, 0.01], [-0.01, 0.02, 0.02]]},
    "hard_iron": {"offset_nT": [300.0, -200.0, 150.0]},
}
CURRENT = {"motor_current": {"gain_nT_A": [20.0, -10.0, 15.0]}}


def _posed(hidden: dict[str, Any], *, stated: float, iron_known: bool = True) -> LinearProblem:
    """A log without attitude beside a model that knows its iron, the strength stated as a multiple of the true one."""
    given = without_attitude(recording(hidden=IRON | hidden))
    problem = pose(given, None, STRENGTH_NT * stated, tuple(effect_table.build(IRON, None, "test")))
    return replace(problem, iron_known=iron_known)


@pytest.mark.parametrize("hidden", [{}, CURRENT], ids=["alone", "beside a current"])
def test_a_strength_that_is_two_percent_off_is_told_as_such(hidden: dict[str, Any]) -> None:
    found = other_strength(_posed(hidden, stated=1.02))
    assert found is not None
    assert found.scale == pytest.approx(1 / 1.02, abs=2e-3)
    assert found.given_nT == pytest.approx(0.02 * STRENGTH_NT, rel=0.1)


@pytest.mark.parametrize("hidden", [{}, CURRENT, {"hard_iron_drift": {"rate_nT_h": [500.0, 300.0, -200.0]}}])
def test_a_right_strength_is_not_doubted(hidden: dict[str, Any]) -> None:
    assert other_strength(_posed(hidden, stated=1.0)) is None


def test_without_the_models_iron_a_factor_cannot_be_told() -> None:
    assert other_strength(_posed({}, stated=1.02, iron_known=False)) is None


def _along(axes: list[list[float]], model: dict[str, Any]) -> Diagnosis:
    """A log whose magnetometer has other axes than the body, beside a model."""
    given = recording(1000, hidden=IRON)
    turned = replace(given, mag_nT=given.mag_nT @ np.array(axes, dtype=float).T)
    return diagnose(turned, ModelSpec.model_validate({"effects": model}), field_enu_nT=FIELD_ENU_NT, fitted_base=True)


def test_axes_of_another_frame_are_told_by_name() -> None:
    (down,) = turned_axes(_along([[1, 0, 0], [0, -1, 0], [0, 0, -1]], {}))
    assert "lie along the body's x, -y, -z:" in down
    (aside,) = turned_axes(_along([[0, -1, 0], [1, 0, 0], [0, 0, 1]], {}))
    assert "lie along the body's -y, x, z:" in aside


def test_axes_that_are_the_bodys_or_that_the_model_knows_are_not_told() -> None:
    assert not list(turned_axes(_along([[1, 0, 0], [0, 1, 0], [0, 0, 1]], {})))
    installed = {"misalignment": {"angles_deg": [180.0, 0.0, 0.0]}}
    assert not list(turned_axes(_along([[1, 0, 0], [0, -1, 0], [0, 0, -1]], installed)))
