"""The loop of a selection, round by round: when it ends, and what is a form of what is in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from diagnosis.decision import selection
from diagnosis.decision.selection import (
    Selection,
    _is_cancelled,
    _is_form_of_accepted,
    _next_after_form,
    _refit_settings,
    select,
)
from diagnosis.decision.white_choice import AcceptedEffect, RoundResult
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import Evidence
from diagnosis.evidence.residual_tests import ResidualTests
from diagnosis.library.candidates import Candidate
from diagnosis.policy import STANDARD
from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.effects.currents import MotorCurrent
from sim.effects.dynamics import Latency
from sim.effects.earth import RegionalField
from sim.effects.iron import SoftIron
from sim.effects.nonlinearity import Hysteresis
from sim.effects.offsets import OffsetJump
from sim.effects.parameters import ACTIVE_WINDOW
from tests.diagnosis.synthetic import problem

CLEAN = ResidualTests({}, (), 0.0, ())
LEFT = replace(CLEAN, why=("something",))
POSED = problem(n=1500)
KIN = [effect for effect in EFFECTS if effect.traits.family][:2]
Play = Callable[..., tuple[Selection, list[int]]]


def _one(effect: type[Effect], strength: float = 10.0, *others: str, **settings: Any) -> AcceptedEffect:
    nothing: Any = None
    candidate = Candidate(effect, tuple(settings.items()))
    return AcceptedEffect(Evidence(candidate, 100.0, 1.0, strength, 1.0, nothing, nothing, 3), others)


def _so_far(*accepted: AcceptedEffect, after: ResidualTests = LEFT) -> Selection:
    start = Baseline.of(POSED)
    return Selection(accepted, start, start, LEFT, after, (), frozenset())


@pytest.fixture(autouse=True)
def _nothing_is_undone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Evidence, "explained_rms", lambda self, baseline: self.strength)


@pytest.fixture
def play(monkeypatch: pytest.MonkeyPatch) -> Play:
    """Let rounds choose what is given; `after`: what is left then. Gives the selection and how many were in before."""

    def played(*rounds: AcceptedEffect, after: ResidualTests = LEFT) -> tuple[Selection, list[int]]:
        choices, asked = iter(rounds), list[int]()

        def round_(so_far: Selection, *_: object) -> RoundResult:
            asked.append(len(so_far.accepted))
            return RoundResult(next(choices, None), ())

        monkeypatch.setattr(selection, "_choose", round_)
        monkeypatch.setattr(selection, "residual_tests", lambda *_: LEFT)
        monkeypatch.setattr(selection, "_completed", lambda so_far: replace(so_far, after=after))
        monkeypatch.setattr(selection, "_refit_settings", lambda chosen, found, *_: list(found))
        monkeypatch.setattr(selection, "_next_after_form", lambda *_: None)
        return select(POSED), asked

    return played


def test_the_loop_ends_where_nothing_is_left(play: Play) -> None:
    assert play(_one(MotorCurrent), _one(RegionalField), after=CLEAN)[1] == [0]
    assert play(_one(MotorCurrent), _one(RegionalField))[1] == [0, 1, 2]
    assert play()[1] == [0]


def test_an_effect_that_is_a_form_of_what_is_in_is_listed_beside_it_and_ends_the_loop(play: Play) -> None:
    found = play(_one(KIN[0]), _one(KIN[1]), _one(RegionalField))[0].accepted
    assert [(one.name, one.alternatives) for one in found] == [(KIN[0].name, (KIN[1].name,))]


def test_a_second_effect_that_the_first_may_be_is_a_form_of_it(play: Play) -> None:
    found = play(_one(MotorCurrent, 10.0, RegionalField.name), _one(RegionalField), _one(SoftIron))[0].accepted
    assert [one.form_of for one in found] == [None, MotorCurrent.name, None]
    found = play(_one(RegionalField), _one(MotorCurrent, 10.0, RegionalField.name))[0].accepted
    assert [one.form_of for one in found] == [None, RegionalField.name]


def test_what_has_no_name_speaks_against_none_where_the_loop_ends(play: Play, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the constant of the field that the round beside it left."""
    monkeypatch.setattr(selection, "_final_tests", lambda tests, *_: CLEAN)
    assert play(_one(MotorCurrent))[0].after.clean


@pytest.mark.parametrize(
    ("effect", "first", "second", "form"),
    [
        (Hysteresis, {"threshold_nT": 1000.0}, {"threshold_nT": 900.0}, True),
        (Hysteresis, {ACTIVE_WINDOW.name: (20.0, 50.0)}, {ACTIVE_WINDOW.name: (80.0, 90.0)}, False),
        (OffsetJump, {"time_s": 20.0}, {"time_s": 50.0}, False),
    ],
)
def test_the_same_effect_at_another_of_its_listed_values_is_a_form(
    effect: type[Effect], first: dict[str, Any], second: dict[str, Any], form: bool
) -> None:
    """At another time it is another event."""
    assert _is_form_of_accepted(_one(effect, **second), [_one(effect, **first)], [], STANDARD) is form


@pytest.mark.parametrize(("strength", "form"), [(1.0, True), (2.0, False)])
def test_beside_a_form_another_form_is_none_either(
    strength: float, form: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(selection, "_choose", lambda *_: RoundResult(_one(RegionalField, strength), ()))
    monkeypatch.setattr(selection, "tests_with_effects", lambda *_: LEFT)
    monkeypatch.setattr(AcceptedEffect, "columns", lambda *_: np.zeros((1500, 3, 1)))
    found = _next_after_form(_so_far(_one(MotorCurrent)), {}, _one(Latency))
    assert (found is None) is form


@pytest.mark.parametrize(("kept", "others", "undone"), [(0.9, (), False), (1.1, (), True), (1.1, ("r",), False)])
def test_what_is_undone_by_what_is_in_is_none(
    kept: float, others: tuple[str, ...], undone: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """But what could stand for it shares its course: that is one cause with it."""
    chosen = _one(RegionalField)
    taken = STANDARD.little * chosen.evidence.strength / kept
    monkeypatch.setattr(Evidence, "explained_rms", lambda *_: taken)
    first = _one(MotorCurrent, 10.0, *(chosen.name for _ in others))
    assert _is_cancelled(chosen, [first], Baseline.of(POSED)) is undone
    assert not _is_cancelled(chosen, [], Baseline.of(POSED))


def test_what_has_a_window_is_not_settled_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its window was found with it."""
    monkeypatch.setattr(AcceptedEffect, "columns", lambda *_: np.zeros((1500, 3, 1)))
    monkeypatch.setattr(selection, "judge_candidate", lambda *_: _one(SoftIron, 1.0).evidence)
    windowed, whole = _one(SoftIron, **{ACTIVE_WINDOW.name: (20.0, 50.0)}), _one(SoftIron)
    start, members = Baseline.of(POSED), {SoftIron.name: [Candidate(SoftIron)]}
    settled = _refit_settings(_one(MotorCurrent), [windowed, whole], members, start)
    assert [one.evidence.strength for one in settled] == [10.0, 1.0]


def test_beside_white_noise_no_rest_has_a_colour_and_alone_nothing_is_sought_beyond(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    given: list[tuple[Any, ...]] = []
    monkeypatch.setattr(selection, "choose_coloured", lambda *args: given.append(args) or RoundResult(None, ()))
    monkeypatch.setattr(selection, "rank_windowed", lambda *_: ["window"])
    monkeypatch.setattr(selection, "first_form_evidence", lambda *_: [])
    selection._choose(_so_far(after=CLEAN), {})
    assert not given
    for alone in (True, False):
        selection._choose(_so_far(), {}, alone=alone)
    assert [(args[4], args[6] is None) for args in given] == [(["window"], True), (["window"], False)]


def test_behind_a_filter_noise_has_a_memory_of_some_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(selection, "run_residual_tests", lambda *args, tails: replace(CLEAN, why=(str(args[-1]),)))
    baseline = Baseline.of(POSED)
    memories = [selection.residual_tests(baseline, [name]).why[0] for name in (MotorCurrent.name, Latency.name)]
    assert memories == ["1", str(STANDARD.filter_memory)]


def test_what_effects_leave_is_asked_for_an_error_of_the_field(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(selection, "_with_earth_vector", lambda tests, baseline: LEFT)
    assert selection.tests_with_effects(Baseline.of(POSED), ()) is LEFT
