"""What a hearing refuses, and where it does not ask: each rule with all others out of its way."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.decision import coloured_choice
from diagnosis.decision.coloured_choice import (
    ATTITUDE_WANDER,
    LIKE_COURSE,
    LIKE_EARTH_FRAME,
    LIKE_HEADING,
    LOSS_ALONG_FIELD,
    NO_BETTER_THAN_SURROGATES,
    NO_GAIN_ALONG_FIELD,
    NOT_SHOWN_BY_MOTION,
    OUTSIDE_WINDOW,
    SIZE_DIFFERS,
    CandidateTest,
    CandidateTrial,
    _accepted_effect,
    _run_trials,
    _stronger_in_window,
    _with_alternatives,
)
from diagnosis.decision.white_choice import AcceptedEffect
from diagnosis.evidence.attitude_like import TURNS
from diagnosis.evidence.candidate_result import TOO_LITTLE
from diagnosis.evidence.candidate_test import CandidateFit
from diagnosis.evidence.held_out import Evidence
from diagnosis.library.candidates import Candidate
from diagnosis.policy import STANDARD
from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.effects.currents import MotorCurrent
from sim.effects.earth import FieldGradient, RegionalField
from sim.effects.iron import SoftIron

TRIED = 7
GAP = 1e5
"""Squares that a start leaves beyond the noise's own."""
LATE = [one for one in EFFECTS if one.traits.family][:2]
BESIDE: Any = SimpleNamespace(rows=SimpleNamespace(policy=STANDARD))


def _evidence(effect: type[Effect] = RegionalField, gain: float = 100.0, **changes: Any) -> Evidence:
    nothing: Any = None
    return replace(Evidence(Candidate(effect, tried=TRIED), gain, 1.0, 1.0, 1.0, nothing, nothing, 3), **changes)


def _fit(effect: type[Effect] = RegionalField, gain: float = 100.0) -> CandidateFit:
    nothing: Any = None
    return CandidateFit(_evidence(effect, gain), np.zeros((1, 3, 3)), nothing, nothing, gain)


def _baseline(squares: float = GAP, **problem: Any) -> Any:
    posed = {"policy": STANDARD, "turns": True, "compares_across": True, "level": None, "target": np.zeros((0, 3))}
    baseline = SimpleNamespace(problem=SimpleNamespace(**posed | problem), squares=squares, accepted_columns=())
    baseline.with_columns = lambda columns: baseline
    return baseline


def _test(baseline: Any = None, by_chance: float = 0.0, *, clean: bool = True) -> CandidateTest:
    beside: Any = SimpleNamespace(surrogate_gains=lambda one, problem: np.array(15 * [0.0] + [by_chance]))
    return CandidateTest(baseline or _baseline(), beside, _baseline(), lambda baseline, name: clean)


@pytest.mark.parametrize(
    ("effect", "survival", "coloured", "turns", "refused"),
    [
        (RegionalField, 0.01, True, True, True),
        (RegionalField, 0.06, True, True, False),
        (RegionalField, 0.01, False, True, False),
        (RegionalField, 0.01, True, False, False),
        (MotorCurrent, 0.01, True, True, False),
    ],
)
def test_beside_colour_what_the_motion_hardly_shows_is_made_up_by_errors_of_the_attitude(
    effect: type[Effect], survival: float, coloured: bool, turns: bool, refused: bool
) -> None:
    """Where the sensor turns, of what goes with the attitude."""
    heard = _test(_baseline(turns=turns))
    found = heard._refusal_by_survival(_evidence(effect, survival=survival), coloured)
    assert found == (NOT_SHOWN_BY_MOTION if refused else "")


@pytest.mark.parametrize(("share", "coloured", "refused"), [(0.04, True, True), (0.06, True, False), (0, False, False)])
def test_beside_colour_an_effect_explains_enough_of_the_gap(share: float, coloured: bool, refused: bool) -> None:
    assert bool(_test()._refusal_by_share(_baseline((1 - share) * GAP), coloured)) is refused


@pytest.mark.parametrize("coloured", [True, False])
def test_a_course_of_time_is_asked_beside_colour_alone(coloured: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    courses = [f"{of}_course_explains_more" for of in ("time", "field", "place")]
    for course in courses:
        for one in courses:
            monkeypatch.setattr(coloured_choice, one, lambda *_, says=one == course: says)
        assert bool(_test()._refusal_by_any_course(_fit(), coloured)) is coloured


@pytest.mark.parametrize("coloured", [True, False])
def test_a_wander_of_the_attitude_is_asked_beside_colour_alone(coloured: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the evidence that is needed there."""
    monkeypatch.setattr(coloured_choice, "with_attitude_wander", lambda *_: BESIDE)
    monkeypatch.setattr(
        coloured_choice, "attitude_wander_explains_more", lambda one, wander, needed: wander is BESIDE and needed == 7.0
    )
    told = _test()._refusal_by_wander(_fit(MotorCurrent), _baseline(), coloured, 7.0)
    assert told == (ATTITUDE_WANDER if coloured else "")


@pytest.mark.parametrize(
    ("effect", "along", "share", "sees", "refused"),
    [
        (FieldGradient, 7.5, 0.7, True, False),
        (FieldGradient, 6.5, 0.7, True, True),
        (FieldGradient, 7.5, 0.6, True, True),
        (FieldGradient, 7.5, 0.7, False, True),
        (MotorCurrent, 7.5, 0.7, True, True),
    ],
)
def test_a_field_of_its_own_that_stands_along_the_field_is_no_wander_of_the_attitude(
    effect: type[Effect], along: float, share: float, sees: bool, refused: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the evidence that is needed and most of what is there, for an error of the attitude has nothing there."""
    monkeypatch.setattr(coloured_choice, "with_attitude_wander", lambda *_: BESIDE)
    monkeypatch.setattr(coloured_choice, "attitude_wander_explains_more", lambda *_: True)
    monkeypatch.setattr(coloured_choice, "gain_along_field", lambda *_: along)
    monkeypatch.setattr(coloured_choice, "share_along_field", lambda *_: share)
    baseline = _baseline(compares_across=sees)
    assert bool(_test(baseline)._refusal_by_wander(_fit(effect), baseline, True, 7.0)) is refused


@pytest.mark.parametrize(
    ("rule", "says", "words"),
    [
        ("follows_heading", True, LIKE_HEADING),
        ("follows_earth_frame", True, LIKE_EARTH_FRAME),
        ("equivalent_course", "depth", LIKE_COURSE.format("depth")),
        ("recurs_outside_window", True, OUTSIDE_WINDOW),
    ],
)
def test_what_has_another_course_is_no_tone_and_has_no_window(
    rule: str, says: object, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for one in ("follows_heading", "follows_earth_frame", "equivalent_course", "recurs_outside_window"):
        monkeypatch.setattr(coloured_choice, one, lambda *_, one=one: one == rule and says)
    assert _test()._refusal_by_course(_evidence(), _baseline()) == words


@pytest.mark.parametrize(
    ("coloured", "part", "refused"),
    [(False, 0.08, False), (False, 0.12, True), (True, 0.25, False), (True, 0.35, True)],
)
def test_one_size_is_asked_more_strictly_where_nothing_is_left(
    coloured: bool, part: float, refused: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """True effects add 3 % with coefficients of their own in parts of the run, beside another effect 15 %."""
    monkeypatch.setattr(coloured_choice, "coefficients_change", lambda one, beside, most: part > most)
    assert (_test()._refusal_by_size(_fit(), coloured) == SIZE_DIFFERS) is refused


@pytest.mark.parametrize(
    ("effect", "coloured", "problem", "shown", "nats", "refusal"),
    [
        (FieldGradient, True, {}, False, 0.0, NO_GAIN_ALONG_FIELD),
        (FieldGradient, True, {}, True, 0.0, ""),
        (FieldGradient, False, {}, False, 0.0, ""),
        (FieldGradient, False, {}, False, -5.0, LOSS_ALONG_FIELD),
        (FieldGradient, True, {"compares_across": False}, False, -5.0, ""),
        (MotorCurrent, True, {}, False, 0.0, ""),
        (MotorCurrent, True, {}, False, -5.0, LOSS_ALONG_FIELD),
        (MotorCurrent, True, {}, False, -4.0, ""),
        (MotorCurrent, True, {"level": "known"}, False, 0.0, NO_GAIN_ALONG_FIELD),
        (MotorCurrent, False, {"level": "known"}, False, -5.0, ""),
    ],
)
def test_an_error_of_the_attitude_has_nothing_along_the_field(
    effect: type[Effect],
    coloured: bool,
    problem: dict[str, Any],
    shown: bool,
    nats: float,
    refusal: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A field of its own must show there beside colour, all must beside the dip, and nothing may be denied there."""
    monkeypatch.setattr(coloured_choice, "explains_along_field", lambda before, after, tried: shown and tried == TRIED)
    monkeypatch.setattr(coloured_choice, "gain_along_field", lambda *_: nats)
    assert _test(_baseline(**problem))._refusal_along_the_field(_fit(effect), _baseline(), coloured) == refusal


@pytest.fixture
def unrefused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing but what it gains speaks against an effect."""
    monkeypatch.setattr(CandidateTest, "_refusal", lambda *_: "")
    monkeypatch.setattr(Candidate, "columns", lambda *_: None)
    monkeypatch.setattr(coloured_choice, "attitude_explains_as_much", lambda *_: True)


@pytest.mark.usefixtures("unrefused")
@pytest.mark.parametrize(
    ("gain", "by_chance", "clean", "refusal"),
    [
        (20.0, 0.0, True, ""),
        (20.0, 0.0, False, TOO_LITTLE),
        (30.0, 0.0, False, ""),
        (30.0, 96.0, True, TOO_LITTLE),
        (80.0, 79.0, True, ""),
        (80.0, 81.0, True, NO_BETTER_THAN_SURROGATES),
    ],
)
def test_an_effect_gains_more_than_what_is_none(
    gain: float, by_chance: float, clean: bool, refusal: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their mean inflates what it gains, and none of them gains as much."""
    monkeypatch.setattr(coloured_choice, "with_attitude_wander", lambda *_: None)
    trial = _test(by_chance=by_chance, clean=clean).of(_fit(gain=gain))
    assert (trial.refusal, trial.coloured) == (refusal, not clean)
    assert trial.attitude_suffices is (
        clean and not refusal
    )  # an error of the attitude is asked of what stands and leaves nothing


@pytest.mark.parametrize(
    ("always", "gain", "far"), [(100, 130, False), (100, 135, True), (20, 40, False), (20, 46, True)]
)
def test_a_window_gains_far_more_than_any_effect_of_the_whole_run(
    always: float, gain: float, far: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Candidate, "columns", lambda *_: None)
    rows = SimpleNamespace(bin=lambda columns: columns)
    beside: Any = SimpleNamespace(rows=rows, fit_candidate=lambda one, columns: _fit(gain=one.gain))
    assert bool(_stronger_in_window([_evidence(gain=gain)], [_fit(gain=always)], beside, _baseline())) is far


def _told(trial: CandidateTrial, others: list[CandidateFit]) -> tuple[str, set[str]]:
    """What is named of a trial and others, and what it may be instead."""
    found = _with_alternatives(trial, [trial.fit, *others], BESIDE)
    return found.name, set(found.alternatives)


@pytest.mark.parametrize(
    ("best", "other", "gain", "coloured", "inflation", "turned", "alike"),
    [
        (RegionalField, MotorCurrent, 996.0, False, 1.0, False, True),
        (RegionalField, MotorCurrent, 994.0, False, 1.0, False, False),
        (RegionalField, MotorCurrent, 992.0, False, 2.0, False, True),
        (RegionalField, MotorCurrent, 890.0, True, 1.0, False, True),
        (RegionalField, MotorCurrent, 870.0, True, 1.0, False, False),
        (LATE[0], LATE[1], 975.0, False, 1.0, False, True),
        (LATE[0], LATE[1], 960.0, False, 1.0, False, False),
        (LATE[0], LATE[1], 560.0, True, 1.0, False, True),
        (LATE[0], LATE[1], 540.0, True, 1.0, False, False),
        (FieldGradient, RegionalField, 994.0, False, 1.0, False, True),
        (FieldGradient, RegionalField, 975.0, False, 1.0, False, False),
        (FieldGradient, RegionalField, 975.0, False, 1.0, True, True),
    ],
)
def test_look_alikes_gain_as_much_but_for_chance_and_an_error_of_form(
    best: type[Effect],
    other: type[Effect],
    gain: float,
    coloured: bool,
    inflation: float,
    turned: bool,
    alike: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """More of kin, of the simpler that one makes too, and beside a colour."""

    def near(
        best: CandidateFit, others: list[CandidateFit], beside: Any, chance: float, share: float
    ) -> list[CandidateFit]:
        return [one for one in others if best.gain - one.gain < max(chance, share * best.gain)]

    monkeypatch.setattr(coloured_choice, "find_look_alikes", near)
    trial = CandidateTrial(_fit(best, 1000.0), inflation, coloured, 0.0, "", turned)
    name, alternatives = _told(trial, [_fit(other, gain)])
    assert {name, *alternatives} == ({best.name, other.name} if alike else {best.name})


def test_where_an_error_of_the_attitude_does_as_well_it_is_a_look_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(coloured_choice, "find_look_alikes", lambda *_: [])
    error = next(effect for effect in EFFECTS if effect.name in TURNS and effect is not RegionalField)
    ranking = [_evidence(), _evidence(error), _evidence(SoftIron)]
    for turned in (True, False):
        one = _fit()
        found = _accepted_effect([CandidateTrial(one, 1.0, False, 0.0, "", turned)], [one], BESIDE, ranking)
        assert found is not None
        assert found.alternatives == ((error.name,) if turned else ())


def test_the_strongest_alone_is_asked_beside_another() -> None:
    asked: list[CandidateFit] = []
    refusing: Any = SimpleNamespace(
        of=lambda one: CandidateTrial(one, 1.0, True, 0.0, NO_GAIN_ALONG_FIELD),
        is_accepted_with_another=lambda one, refusal: asked.append(one),
    )
    tried = [_fit(), _fit(MotorCurrent)]
    trials = _run_trials(refusing, tried)
    assert asked == tried[:1]
    assert _accepted_effect(trials, tried, BESIDE, []) is None


def test_the_strongest_that_a_wander_does_better_than_is_tried_beside_another() -> None:
    """What is left of the other may look like a wander; each is refused by itself, the second and the third alike."""
    asked: list[CandidateFit] = []
    tried = [_fit(), _fit(MotorCurrent), _fit(SoftIron)]
    says = dict(zip(map(id, tried), ("less", ATTITUDE_WANDER, ATTITUDE_WANDER), strict=True))
    refusing: Any = SimpleNamespace(
        of=lambda one: CandidateTrial(one, 1.0, True, 0.0, says[id(one)]),
        is_accepted_with_another=lambda one, refusal: asked.append(one),
    )
    assert _accepted_effect(_run_trials(refusing, tried), tried, BESIDE, []) is None
    assert asked == tried[1:2]


def test_the_same_effect_again_is_no_other_beside_which_one_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Candidate, "columns", lambda *_: None)
    again = replace(_test(), find_next=lambda baseline, one: AcceptedEffect(one, ()))
    assert not again.is_accepted_with_another(_fit(), SIZE_DIFFERS)


@pytest.mark.parametrize(
    ("one", "other", "refusal", "asked"),
    [
        (RegionalField, FieldGradient, ATTITUDE_WANDER, False),
        (FieldGradient, RegionalField, NO_GAIN_ALONG_FIELD, False),
        (RegionalField, FieldGradient, SIZE_DIFFERS, True),
        (RegionalField, MotorCurrent, ATTITUDE_WANDER, True),
        (MotorCurrent, RegionalField, ATTITUDE_WANDER, True),
    ],
)
def test_two_of_the_field_are_no_witness_of_each_other_against_an_error_of_the_attitude(
    one: type[Effect], other: type[Effect], refusal: str, asked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They are pieces of its course; where one may be asked beside the other it is found to stand here."""
    monkeypatch.setattr(Candidate, "columns", lambda *_: None)
    monkeypatch.setattr(
        coloured_choice.ColouredBaseline, "of", lambda *_: SimpleNamespace(fit_candidate=lambda *_: None)
    )
    monkeypatch.setattr(CandidateTest, "of", lambda *_: SimpleNamespace(refusal=""))
    heard = replace(_test(), find_next=lambda baseline, _: AcceptedEffect(_evidence(other), ()))
    assert heard.is_accepted_with_another(_fit(one), refusal) is asked
