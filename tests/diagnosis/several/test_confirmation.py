"""A second recording: what it bears out, what it has of another size, what it has not, with attitude and without."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

from diagnosis.result import Diagnosis
from diagnosis.several.transfer import confirmed
from diagnosis.workflow import diagnose
from recordings import Recording
from sim.scenario import ModelSpec
from tests.diagnosis.several.test_workflow import motor
from tests.diagnosis.synthetic import ALL_BUT_SEVEN, FIELD_ENU_NT, STRENGTH_NT, recording, without_attitude

MODEL = ModelSpec.model_validate({"effects": {"white_noise": {"std_nT": [2.0] * 3}}})


def flight(hidden: dict[str, Any], attitude: bool, seed: int) -> Recording:
    made = recording(1500, seed=seed, hidden=hidden)
    return made if attitude else without_attitude(made)


@cache
def first(attitude: bool) -> Diagnosis:
    return diagnose(
        flight(motor(1.0), attitude, 1),
        MODEL,
        field_enu_nT=FIELD_ENU_NT if attitude else None,
        strength_nT=STRENGTH_NT,
        fitted_base=True,
        without=ALL_BUT_SEVEN,
    )


@pytest.mark.parametrize("attitude", [True, False])
@pytest.mark.parametrize(("share", "evidence"), [(1.0, "transferred"), (1.5, "single-run"), (0.0, "single-run")])
def test_only_the_same_coefficients_are_borne_out(attitude: bool, share: float, evidence: str) -> None:
    second = flight(motor(share), attitude, 9)
    known = confirmed(first(attitude), second, MODEL, FIELD_ENU_NT if attitude else None, STRENGTH_NT)
    assert [(one.name, str(one.transfer)) for one in known.named] == [("motor_current", evidence)]
    assert ("does not confirm motor_current" in " ".join(known.advice)) is (evidence == "single-run")
    assert ("not confirmed by the second recording" in known.sentence) is (evidence == "single-run")
    assert "confirmed by the second recording" in known.sentence


def test_a_recording_without_attitude_says_nothing_of_one_with_it() -> None:
    second = flight(motor(1.0), False, 9)
    assert confirmed(first(True), second, MODEL, None, STRENGTH_NT).named[0].transfer == "single-run"
