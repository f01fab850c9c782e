"""Rules that are switched off, numbers that are multiplied, and the table of what either changed."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import pytest

from benchmarks.diagnosis.ablation import Changed, multiplied, table
from benchmarks.diagnosis.margins import LIMITS, WatchedNumber, watched_policy
from benchmarks.diagnosis.rules import RULES, watched
from benchmarks.diagnosis.trials import Trial
from diagnosis.decision import coloured_choice, verdict_rules
from diagnosis.policy import STANDARD
from diagnosis.workflow import diagnose
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import FIELD_ENU_NT, recording


@pytest.mark.parametrize("rule", RULES.values(), ids=list(RULES))
def test_every_rule_is_where_the_list_says(rule: Any) -> None:
    module, _, path = rule.place.partition(":")
    found: Any = importlib.import_module(module)
    for part in path.split("."):
        found = getattr(found, part)
    assert callable(found)


def test_a_rule_that_is_off_has_no_say_and_comes_back() -> None:
    before = coloured_choice.attitude_suffices
    with watched("coloured_choice.attitude_suffices"):
        assert coloured_choice.attitude_suffices(None, None, None) is False  # type: ignore[arg-type]
    assert coloured_choice.attitude_suffices is before


def test_a_rule_of_a_table_is_watched_through_the_table() -> None:
    before = verdict_rules.NAME_DOUBTS
    with watched("verdict_rules.channel_in_residual"):
        assert verdict_rules.NAME_DOUBTS[0](None) == ()  # type: ignore[arg-type,comparison-overlap]
    assert verdict_rules.NAME_DOUBTS is before


def test_a_whole_number_stays_whole_and_is_never_nothing() -> None:
    assert (multiplied(3, 0.5), multiplied(1, 0.5), multiplied((1, 4), 2.0)) == (2, 1, (2, 8))
    assert Changed(Trial("null", "auv", (), (), 0), number="alpha", factor=2.0).policy().alpha == 2 * STANDARD.alpha


def _row(key: str, what: str, names: list[str], fired: dict[str, int]) -> dict[str, Any]:
    return {
        "key": f"{key} [{what}]", "what": what, "kind": "null", "verdict": "none", "fired": fired,
        "names": [(name, [], "held-out") for name in names],
    }  # fmt: skip


def test_the_table_counts_other_answers_by_whether_they_are_right() -> None:
    """Of two nulls the rule keeps one from a false name, and makes that of the other."""
    rule = next(iter(RULES))
    plain = [_row("a", "", [], {rule: 1}), _row("b", "", ["hysteresis"], {rule: 2})]
    without = [_row("a", rule, ["eddy_current"], {}), _row("b", rule, [], {})]
    lines = list(table([*plain, *without]))
    assert f"| {rule} | 2 | 2 | 2 | 1 | 1 | 0 |" in lines
    assert sum("| 0 | | | | | |" in line for line in lines) == len(RULES) - 1


@pytest.mark.parametrize("value", [1.5, np.float64(1.5), np.array([0.1, 1.5])])
def test_a_watched_number_tells_the_comparisons_that_another_value_would_turn(value: Any) -> None:
    turned: set[tuple[str, float]] = set()

    def note(name: str, turns: Any) -> None:
        turned.update((name, factor) for factor in (0.5, 2.0) if turns(factor))

    two = WatchedNumber.of("two", lambda factor: 2.0 * factor, note)
    assert np.all(value < two)
    assert turned == {("two", 0.5)}
    assert np.all(value < 3 * two**2)
    assert turned == {("two", 0.5)}
    assert np.any(value > 0.6 * two)
    assert turned == {("two", 0.5), ("two", 2.0)}
    assert np.all(np.maximum(value, two) == 2.0)


def test_with_watched_numbers_a_diagnosis_answers_the_same() -> None:
    problem_of = ModelSpec.model_validate({"field": {"enu_nT": FIELD_ENU_NT.tolist()}})
    given = recording(hidden={"motor_current": {"gain_nT_A": [3.0, -1.0, 2.0]}})
    with watched_policy((0.5, 2.0)) as (policy, turned):
        found = diagnose(given, problem_of, fitted_base=True, policy=policy)
    assert found.sentence == diagnose(given, problem_of, fitted_base=True).sentence
    assert {name for name, _ in turned} <= set(LIMITS)
    assert turned
