"""What only rises goes with time and with every channel that only rises: no name alone, whatever its form."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from diagnosis.decision.monotone_courses import with_rival_channels
from diagnosis.evidence.localise import TIME
from diagnosis.result import Diagnosis, EvidenceKind, NamedEffect
from diagnosis.verdict import Verdict
from diagnosis.workflow import diagnose
from recordings import Recording
from recordings.channels import TEMPERATURE
from sim.effects import BY_NAME, EFFECTS
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import FIELD_ENU_NT, NOISE_NT, problem, recording

WARM = next(effect for effect in EFFECTS if any(p.unit == "nT/K" for p in effect.parameters()))
WARM_SCALE = next(effect for effect in EFFECTS if any(p.unit == "1/K" for p in effect.parameters()))
DRIFT = next(effect for effect in EFFECTS if any(p.unit == "nT/h" for p in effect.parameters()))
JUMP = next(effect for effect in EFFECTS if effect.search_role() == "moment")
DRIVEN = next(effect for effect in EFFECTS if effect.with_role("motor") and not effect.search_role())
TONE, RIPPLE = BY_NAME["steady_tone"], BY_NAME["current_ripple"]
SOFT_IRON, PART_S = BY_NAME["soft_iron"], (150.0, 250.0)
MATRIX = [[5e-4, 0.0, 0.0], [0.0, -3e-4, 1e-4], [0.0, 1e-4, 2e-4]]
N = 4000
AXES = np.array([3.0, -2.0, 4.0])
UP = np.linspace(0.0, 1.0, N)


def _told(given: Recording, without: frozenset[str] = frozenset()) -> Diagnosis:
    model = ModelSpec.model_validate(
        {"effects": {"white_noise": {"std_nT": 2.0}}, "field": {"enu_nT": FIELD_ENU_NT.tolist()}}
    )
    return diagnose(given, model, without=without)


def _seen(temperature_degC: Any, course: Any) -> Recording:
    given = recording()
    return replace(given, temperature_degC=temperature_degC, mag_nT=given.mag_nT + np.outer(course, AXES))


@pytest.mark.parametrize(
    ("missing", "found", "rival"),
    [(WARM, DRIFT, TEMPERATURE), pytest.param(DRIFT, WARM, TIME, marks=pytest.mark.slow)],
)
def test_without_the_cause_in_the_library_what_shares_its_course_is_no_name_alone(missing, found, rival) -> None:
    told = _told(_seen(15 + 5 * UP, UP), frozenset({missing.name}))
    assert told.verdict is Verdict.CLASS
    assert (told.named[0].name, told.named[0].rivals) == (found.name, (rival,))
    assert f"an effect of {rival}" in told.sentence
    assert any(rival in line for line in told.advice)
    assert told.as_dict()["effects"][0]["rivals"] == [rival]


@pytest.mark.parametrize(
    ("effect", "temperature_degC", "rivals"),
    [
        (WARM((3.0, -2.0, 4.0)), 15 + 5 * np.sqrt(UP), (TIME,)),
        (WARM((3.0, -2.0, 4.0)), 15 + 5 * np.sin(7 * UP), ()),
        (WARM_SCALE((3e-4, -2e-4, 4e-4)), 15 + 5 * np.sqrt(UP), (TIME,)),
        (WARM_SCALE((3e-4, -2e-4, 4e-4)), 15 + 5 * np.sin(7 * UP), ()),
        (DRIFT((9.0, 2.0, 4.0)), 15 - 5 * UP**2, (TEMPERATURE,)),
        (DRIFT((9.0, 2.0, 4.0)), 15 + 5 * np.sin(7 * UP), ()),
        (JUMP(200.0, (3.0, -2.0, 4.0)), 15 + 5 * UP, ()),
        (JUMP(200.0, (3.0, -2.0, 4.0)), 15 + 5.0 * (UP * N * 0.1 > 200.0), (TEMPERATURE,)),
    ],
)
def test_only_what_rises_all_the_time_has_rivals(effect, temperature_degC, rivals) -> None:
    posed = problem(replace(recording(), temperature_degC=temperature_degC))
    named = NamedEffect(effect, (), EvidenceKind.HELD_OUT, 100.0, 1.0)
    assert with_rival_channels(posed, named).rivals == rivals
    assert with_rival_channels(posed, replace(named, alternatives=(WARM.name, DRIFT.name))).rivals == ()
    assert with_rival_channels(posed, replace(named, kind=EvidenceKind.SPECTRUM)).rivals == ()


@pytest.mark.parametrize(
    ("temperature_degC", "course", "listed"),
    [
        (15 + 5 * UP, 2.3 * (1 - np.exp(-2 * UP)), (WARM.name,)),
        (15 + 5 * np.sin(7 * UP), 2.3 * (1 - np.exp(-2 * UP)), ()),
    ],
)
def test_a_drift_lists_a_temperature_that_rises_with_it(temperature_degC: Any, course: Any, listed: Any) -> None:
    (one,) = _told(_seen(temperature_degC, course)).named
    assert (one.name, one.alternatives, one.rivals) == (DRIFT.name, listed, ())


def test_a_drift_and_a_temperature_of_one_course_are_one_cause() -> None:
    """Where it takes both to leave nothing both are in the new model."""
    course = 5 * (UP**2 + np.sqrt(UP))
    told = _told(_seen(15 + 5 * np.sqrt(UP), course))
    (one,) = told.named
    assert (one.name, one.alternatives) == (DRIFT.name, (WARM.name,))
    assert {DRIFT.name, WARM.name} <= told.model.effects.written.keys()
    assert one.strength == pytest.approx(np.std(course) * np.sqrt((AXES**2).mean()) / NOISE_NT, rel=0.05)


def test_a_channel_that_comes_and_goes_drives_two_jumps() -> None:
    on = (UP * N * 0.1 > 150.0) & (UP * N * 0.1 < 250.0)
    posed = problem(replace(recording(), temperature_degC=15 + 5.0 * on))
    back = JUMP(250.0, (-3.0, 2.0, -4.0))
    named = NamedEffect(JUMP(150.0, (3.0, -2.0, 4.0)), (), EvidenceKind.HELD_OUT, 100.0, 1.0, also=(back,))
    assert with_rival_channels(posed, named).rivals == (TEMPERATURE,)
    assert with_rival_channels(posed, replace(named, also=())).rivals == ()


@pytest.mark.parametrize(("off_s", "rivals"), [(250.0, ("payload",)), (300.0, ())])
def test_what_acts_in_a_part_goes_with_a_channel_that_is_on_there_alone(off_s: float, rivals: tuple[str, ...]) -> None:
    """It keeps its window, and may be what the channel switches."""
    given = recording(hidden={SOFT_IRON.name: {"matrix": MATRIX, "active_s": PART_S}})
    on = (given.time_s >= PART_S[0]) & (given.time_s < off_s)
    told = _told(replace(given, channels={"payload": 2.0 - on}))
    (one,) = told.named
    assert (one.name, one.rivals) == (SOFT_IRON.name, rivals)
    assert one.effect.active_s == pytest.approx(PART_S, abs=1.0)
    assert ("an effect of payload" in told.sentence) is bool(rivals)
    assert told.verdict is (Verdict.CLASS if rivals else Verdict.NAMED)


@pytest.mark.parametrize(("spread", "rivals"), [(0.1, ("throttle", "current_3_A")), (0.3, ("current_3_A",))])
def test_of_motors_that_run_alike_none_is_named_alone(spread: float, rivals: tuple[str, ...]) -> None:
    """The second motor has some of the fourth's course beside the first's; the third is the first with another gain."""
    given, first, fourth = recording(), np.sin(20 * UP), np.sin(33 * UP)
    second = first + spread * fourth
    currents = np.stack([first, second, 1 - 2 * first, fourth], axis=1)
    posed = problem(replace(given, current_A=currents, channels={"throttle": second}))
    alone = NamedEffect(
        DRIVEN(**{DRIVEN.linear[0]: (3.0, 0.0, 0.0), "motor": 1}), (), EvidenceKind.HELD_OUT, 100.0, 1.0
    )
    assert with_rival_channels(posed, alone).rivals == rivals
    each = replace(alone, also=(DRIVEN(**{DRIVEN.linear[0]: (3.0, 0.0, 0.0), "motor": 2}),))
    assert with_rival_channels(posed, each).rivals == ()
    assert with_rival_channels(posed, replace(alone, effect=DRIVEN(**{DRIVEN.linear[0]: (3.0, 0.0, 0.0)}))).rivals == ()


@pytest.mark.parametrize(("spread", "rivals"), [(0.1, ("throttle", "current_2_A")), (0.3, ())])
def test_a_tone_beside_a_steady_current_may_be_the_motors(spread: float, rivals: tuple[str, ...]) -> None:
    """The library may lack the motor's own tone; where it has one, and lists it, the currents are no further rivals."""
    first = 2 * (1 + spread * np.sqrt(2) * np.sin(20 * UP))
    posed = problem(replace(recording(), current_A=np.stack([first, 3 * first], axis=1), channels={"throttle": first}))
    tone = NamedEffect(TONE((3.0, 0.0, 0.0), 3.7), (), EvidenceKind.HELD_OUT, 100.0, 1.0)
    assert with_rival_channels(posed, tone).rivals == rivals
    assert with_rival_channels(posed, replace(tone, alternatives=(RIPPLE.name,))).rivals == ()
    assert with_rival_channels(posed, replace(tone, effect=RIPPLE((3.0, 0.0, 0.0), 3.7))).rivals == ()
