"""An effect that the model states wrongly is told as that effect, changed; the written model leaves the noise."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from diagnosis.problem.motion import attitude_at, attitude_course
from diagnosis.repair.new_model import lines_of_diff
from diagnosis.result import Diagnosis
from diagnosis.workflow import diagnose
from sim.scenario import ModelSpec
from tests.diagnosis.conftest import BASE
from tests.diagnosis.synthetic import COSTLY, FIELD_ENU_NT, NOISE_NT, recording
from tests.nightly import first_daily
from validation.signals.amplitude import rms

MOTOR: dict[str, Any] = {"motor_current": {"gain_nT_A": [40.0, -25.0, 30.0]}}
GRADIENT = {"gradient_nT_m": [[1.0, 0.5, 0.0], [0.5, -2.0, 0.3], [0.0, 0.3, 1.0]], "origin_enu_m": [0.0, 0.0, 0.0]}


def _times(tables: dict[str, Any], key: str, factor: float) -> dict[str, Any]:
    ((name, table),) = tables.items()
    return {name: {**table, key: (factor * np.array(table[key])).tolist()}}


def _model(**stated: Any) -> ModelSpec:
    return ModelSpec.model_validate({"effects": BASE | stated, "field": {"enu_nT": FIELD_ENU_NT.tolist()}})


def _diagnosed(true: dict[str, Any], stated: dict[str, Any], seed: int, **more: Any) -> Diagnosis:
    return diagnose(recording(3000, seed=seed, hidden=BASE | true), _model(**stated), without=COSTLY, **more)


@pytest.mark.parametrize("factor", first_daily([0.8, -1.0, 0.0, 1.2], daily=2))
def test_a_motor_of_the_model_with_a_wrong_gain_is_named_and_the_iron_is_not_accused(factor: float) -> None:
    found = _diagnosed(MOTOR, _times(MOTOR, "gain_nT_A", factor), seed=3)
    assert [cause.name for cause in found.named] == ["motor_current"]
    assert found.sentence.startswith("Wrong in the model: motor_current: gain_nT_A (")
    assert "iron" not in found.sentence
    (motor,) = (effect for effect in found.model.chain() if effect.name == "motor_current")
    assert motor.gain_nT_A == pytest.approx(MOTOR["motor_current"]["gain_nT_A"], abs=0.5)


def test_a_wrong_gain_is_named_where_the_iron_is_fitted_too() -> None:
    found = _diagnosed(MOTOR, _times(MOTOR, "gain_nT_A", 1.2), seed=4, fitted_base=True)
    assert [cause.name for cause in found.named] == ["motor_current"]
    assert found.resimulated_nT == pytest.approx(NOISE_NT, rel=0.05)


@pytest.mark.parametrize(
    ("true", "key"),
    [
        ({"temperature_scale": {"slope_1_K": [1e-3] * 3}}, "slope_1_K"),
        ({"field_gradient": GRADIENT}, "gradient_nT_m"),
        ({"eddy_current": {"matrix_s": (0.005 * np.eye(3)).tolist(), "time_constant_s": 0.05}}, "matrix_s"),
    ],
)
def test_any_effect_of_the_model_that_is_off_is_one_effect_of_the_new_model(true: dict[str, Any], key: str) -> None:
    ((name, table),) = true.items()
    found = _diagnosed(true, _times(true, key, 1.6), seed=5)
    assert [cause.name for cause in found.named] == [name]
    (changed,) = (effect for effect in found.model.chain() if effect.name == name)
    assert np.array(getattr(changed, key)) == pytest.approx(np.array(table[key]), abs=0.05 * np.abs(table[key]).max())
    assert any(line.startswith("-") for line in lines_of_diff(found.given, found.model)[2:])
    effect = found.as_dict()["effects"][0]
    assert effect["stated"][key] != effect["corrected"][key]


def test_a_wrong_lag_is_found_anew_in_place_of_the_stated_one() -> None:
    true = {"motor_current": {**MOTOR["motor_current"], "lag_s": 0.4}}
    found = _diagnosed(true, {"motor_current": {**MOTOR["motor_current"], "lag_s": 1.4}}, seed=6)
    assert [cause.name for cause in found.named] == ["motor_current"]
    (motor,) = (effect for effect in found.model.chain() if effect.name == "motor_current")
    assert motor.lag_s == pytest.approx(0.4, abs=0.02)
    assert "lag_s 0.4" in found.sentence.split("(stated: ")[0]
    assert "lag_s 1.4 s)" in found.sentence.split("(stated: ")[1]
    assert found.gap.before_nT < 12.0  # the gap that the given model leaves, not one without its motor


def test_a_right_model_is_told_nothing_of() -> None:
    found = _diagnosed(MOTOR, MOTOR, seed=7)
    assert found.verdict == "none"
    assert found.resimulated_nT == pytest.approx(NOISE_NT, rel=0.05)


def test_a_late_attitude_is_part_of_the_written_model() -> None:
    made = recording(3000, seed=8, hidden=BASE)
    course = attitude_course(made.time_s, np.asarray(made.att_q))
    late = replace(made, att_q=attitude_at(course, np.maximum(made.time_s - 0.094, 0.0)))
    found = diagnose(late, _model(), without=COSTLY)
    assert "94 ms later" in found.sentence
    assert found.model.navigation.attitude_delay_s == pytest.approx(0.094, abs=0.001)
    claimed_nT = rms(found.after_nT[found.problem.usable > 0])
    assert found.resimulated_nT == pytest.approx(claimed_nT, rel=0.05)
    again = diagnose(late, found.model)
    assert again.verdict == "none"
    assert again.sentence.startswith("The model agrees")


def test_the_json_tells_what_the_written_model_leaves(diagnosed) -> None:  # type: ignore[no-untyped-def]
    gap = json.loads(json.dumps(diagnosed({"motor_current": {"gain_nT_A": [2.0, -1.0, 4.0]}}).as_dict()))["gap"]
    assert gap["resimulated"]["rms_nT"] == pytest.approx(NOISE_NT, rel=0.05)
    assert gap["before"]["rms_nT"] > 1.1 * gap["resimulated"]["rms_nT"]


SLOPES = {"temperature_scale": {"slope_1_K": [3e-4, -2e-4, 1e-4], "reference_degC": 0.0}}


@pytest.mark.parametrize("seed", first_daily([31, 32, 33]))
def test_another_reference_temperature_is_no_change_of_the_scale(seed: int) -> None:
    """Slopes are known to a hundredth, and the reference is 16 K away: a trace of a scale is left."""
    (found,) = _diagnosed(SLOPES, {}, seed=seed).named
    assert (found.name, [effect.name for effect in found.also]) == ("temperature_scale", ["scale"])


def test_a_change_of_the_iron_beside_another_reference_is_a_finding() -> None:
    found = _diagnosed(SLOPES | {"hard_iron": {"offset_nT": [510.0, -300.0, 800.0]}}, {}, seed=34)
    assert sorted(cause.name for cause in found.named) == ["hard_iron", "temperature_scale"]
