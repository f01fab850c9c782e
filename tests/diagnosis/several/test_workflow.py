"""Several recordings: what holds in all, what differs in one, what one alone shows, what none shows by itself."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from diagnosis.problem.formulation import pose_model
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Transfer
from diagnosis.several import workflow
from diagnosis.several.pooled_effect import Presence
from diagnosis.several.result import PooledDiagnosis
from diagnosis.several.workflow import diagnose_together
from diagnosis.verdict import Verdict
from diagnosis.workflow import Examination, examine
from scenarios.errors import InputError
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import ALL_BUT_SEVEN, FIELD_ENU_NT, recording
from tests.results import check_printed

GAIN = np.array([3.0, -2.0, 4.0])
NAMES = ("first", "second", "third")
IRON = {"soft_iron": {"matrix": [[0.3, 0.1, 0.0], [0.1, -0.2, 0.0], [0.0, 0.1, 0.2]]}}


def motor(share: float) -> dict[str, Any]:
    return {"motor_current": {"gain_nT_A": (share * GAIN).tolist()}} if share else {}


MODEL = ModelSpec.model_validate(
    {"effects": {"white_noise": {"std_nT": [2.0] * 3}}, "field": {"enu_nT": FIELD_ENU_NT.tolist()}}
)


@pytest.fixture(scope="module", autouse=True)
def each_once() -> Iterator[None]:
    """A recording that several lots share is diagnosed by itself once."""
    with pytest.MonkeyPatch.context() as patch_model:
        seen: dict[int, Examination] = {}

        def once(problem: LinearProblem, *given: Any) -> Examination:
            if id(problem) not in seen:  # kept alive by `problem_of`
                seen[id(problem)] = examine(problem, *given)
            return seen[id(problem)]

        patch_model.setattr(workflow, "examine", once)
        yield


@cache
def problem_of(hidden: str, seed: int) -> LinearProblem:
    return pose_model(recording(2000, seed=seed, hidden=json.loads(hidden)), MODEL, None, None, iron_known=False)


def together(*hidden: dict[str, Any], seed: int = 0) -> PooledDiagnosis:
    problems = [problem_of(json.dumps(one), 10 * seed + i) for i, one in enumerate(hidden)]
    return diagnose_together(NAMES[: len(problems)], problems, MODEL, without=ALL_BUT_SEVEN)


@pytest.mark.parametrize("iron", [IRON, pytest.param({}, marks=pytest.mark.slow)], ids=["soft iron", ""])
def test_one_coefficient_in_all_is_transferred_and_pooled(iron: dict[str, Any]) -> None:
    found = together(*[motor(1.0) | iron] * 3)
    (one,) = found.common
    assert (found.verdict, one.name, one.transfer) == (Verdict.NAMED, "motor_current", Transfer.TRANSFERRED)
    std = one.named.spread["gain_nT_A"]
    assert (np.abs(np.array(one.named.effect.gain_nT_A) - GAIN) < 4 * std).all()  # type: ignore[attr-defined]
    assert (std < np.array([each.spread["gain_nT_A"] for each in one.each if each]).min(axis=0)).all()
    assert found.gap.explained == pytest.approx(1.0, abs=0.02)
    for gap in found.gaps:
        before_nT, after_nT = (np.sqrt(np.mean(residual**2)) for residual in (gap.before_nT, gap.after_nT))
        assert before_nT == pytest.approx(gap.gap.before_nT, rel=0.05)
        assert after_nT == pytest.approx(gap.gap.after_nT, rel=0.05) == pytest.approx(2.0, rel=0.1)


JUMP = {"offset_jump": {"time_s": 90.0, "step_nT": [12.0, -9.0, 6.0]}}


def test_a_jump_in_one_of_three_is_no_agreement_with_the_model() -> None:
    found = together({}, JUMP, {})
    assert (found.verdict, found.common) == (Verdict.NAMED, ())
    assert found.sentence.startswith("second, of 3 recordings (2 none, 1 named): ")
    assert "offset_jump" in found.sentence
    told = found.as_dict()
    check_printed(["diagnose"], told)
    assert told["worst"] == "second"
    assert [(one["name"], one["only_in"]) for one in told["effects"]] == [("offset_jump", "second")]


def test_a_jump_in_one_is_told_beside_what_all_have() -> None:
    found = together(motor(1.0), motor(1.0) | JUMP, motor(1.0))
    assert [one.name for one in found.common] == ["motor_current"]
    assert "second alone has offset_jump" in found.sentence


def test_a_third_more_in_one_is_not_transferred_and_its_table_says_which() -> None:
    found = together(motor(1.0), motor(1.0), motor(1.3))
    (one,) = found.common
    assert one.transfer is Transfer.NOT_TRANSFERRED
    assert one.agreement is not None
    assert one.agreement.p < 0.01
    sizes = [np.linalg.norm(each.effect.gain_nT_A) for each in one.each if each]  # type: ignore[attr-defined]
    assert sizes[2] / sizes[0] == pytest.approx(1.3, abs=0.1)
    assert "does not transfer" in " ".join(found.advice)
    assert found.as_dict()["effects"][0]["evidence"] == "not-transferred"


def test_what_one_alone_shows_is_no_name() -> None:
    found = together({}, {}, motor(1.0))
    assert found.common == ()
    (one,) = found.single
    assert (one.name, one.presence) == ("motor_current", (Presence.ABSENT, Presence.ABSENT, Presence.PRESENT))
    assert found.each[2].verdict is Verdict.NAMED


def test_what_two_of_three_show_is_in_some() -> None:
    found = together(motor(1.0), {}, motor(1.0))
    (one,) = found.common
    assert (one.transfer, one.presence[1]) == (Transfer.SOME, Presence.ABSENT)


def test_a_tone_begins_each_run_with_another_phase_and_is_a_name() -> None:
    """By common coefficients it would be none, however plain each recording's own."""
    ripple = {"amplitude_nT_A": [0.6, -0.4, 0.5], "frequency_hz": 2.7}
    found = together(*({"current_ripple": {**ripple, "phase_deg": phase}} for phase in (0.0, 100.0)), seed=5)
    assert [(one.name, one.transfer) for one in found.common] == [("current_ripple", Transfer.NOT_TRANSFERRED)]


def test_an_effect_too_weak_for_each_is_named_by_all_together() -> None:
    found = together(*[motor(0.038)] * 3, seed=3)
    assert all(not one.named for one in found.each)
    assert [one.name for one in found.common] == ["motor_current"]


def test_a_tone_that_sweeps_in_one_leaves_the_name_and_is_told() -> None:
    given = recording(2000, seed=51, hidden=motor(1.0))
    turns = np.cumsum(1.5 + given.time_s / 100) * np.diff(given.time_s)[0]
    swept = replace(given, mag_nT=given.mag_nT + 2.0 * np.sin(2 * np.pi * turns)[:, None])
    second = pose_model(swept, MODEL, None, None, iron_known=False)
    found = diagnose_together(NAMES[:2], [problem_of(json.dumps(motor(1.0)), 50), second], MODEL, without=ALL_BUT_SEVEN)
    assert ([one.name for one in found.common], found.verdict) == (["motor_current"], Verdict.PARTIAL)
    (left,) = found.unexplained
    assert left.startswith("second: structure between 1.")


def test_what_acts_in_a_part_of_one_recording_stays_with_it() -> None:
    window = (60.0, 110.0)
    found = together({}, {}, {"motor_current": {"gain_nT_A": GAIN.tolist(), "active_s": window}})
    (own,) = found.each[2].named
    assert own.effect.active_s == pytest.approx(window, abs=2.0)
    assert (found.common, found.single) == ((), ())


def test_nothing_is_found_where_nothing_is() -> None:
    found = together({}, {}, {})
    assert (found.verdict, found.common, found.single) == (Verdict.NONE, (), ())


def test_recordings_are_told_one_by_one_and_then_by_rounds_until_all_is_clean() -> None:
    """A recording's own steps were told when it was diagnosed; one effect takes one round."""
    said: list[str] = []
    problems = [problem_of(json.dumps(motor(1.0)), i) for i in range(3)]
    diagnose_together(NAMES, problems, MODEL, without=ALL_BUT_SEVEN, say=said.append)
    assert [text for text in said if not text.startswith(NAMES)] == [
        *("all recordings together, round 1", "the simulator with the new models"),
    ]


def test_one_recording_is_not_several() -> None:
    with pytest.raises(InputError, match="a single recording cannot be compared"):
        together({})


def test_a_recording_is_not_held_against_itself() -> None:
    problem = problem_of("{}", 0)
    with pytest.raises(InputError, match="first, second: both recordings have the same field samples"):
        diagnose_together(NAMES[:2], [problem, problem], MODEL)
