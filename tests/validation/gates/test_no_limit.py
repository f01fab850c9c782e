"""A gate passes only under a finite limit that is kept."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from tests.validation.gates.conftest import Scripted, gate_text, row
from validation.gates.gate_groups import NO_LIMIT
from validation.gates.runner import decide_gates


@pytest.mark.parametrize("answers", [0, 3, None])
def test_a_reference_that_never_answers_lets_nothing_pass(answers: int | None, groups_of: Callable) -> None:  # type: ignore[type-arg]
    groups = groups_of(gate_text("vacuous", ratio=2.0, reference="sphere", max_trials=60))

    def told(group: int, run: int) -> list:  # type: ignore[type-arg]
        answered = answers is None or run < answers
        return [row("ellipsoid", 1.0), row("sphere", *((1.0,) if answered else (None, "not converged", "no data")))]

    (outcome,) = decide_gates(groups, Scripted(told))
    assert outcome.verdict == ("pass" if answers is None else "fail")
    assert outcome.failure == ("" if answers is None else NO_LIMIT)


def test_an_estimate_that_its_method_takes_back_exceeds_every_limit(groups_of: Callable) -> None:  # type: ignore[type-arg]
    groups = groups_of(gate_text("loose", limit=1e9), gate_text("paired", "sphere", ratio=1e9, reference="ellipsoid"))
    told = [row("ellipsoid", 1.0, "unobservable", "too level"), row("sphere", 1.0)]
    loose, paired = decide_gates(groups, Scripted(lambda group, run: told))
    assert (loose.verdict, loose.failure) == ("fail", "unobservable: too level")
    assert (paired.verdict, paired.failure) == ("fail", NO_LIMIT)


def test_a_limit_next_to_zero_fails_and_overflows_nothing(groups_of: Callable) -> None:  # type: ignore[type-arg]
    groups = groups_of(gate_text("least", limit=5e-324, max_trials=60))
    (outcome,) = decide_gates(groups, Scripted(lambda group, run: [row("ellipsoid", 1.0)]))
    assert (outcome.verdict, outcome.factor_seen) == ("fail", 0.0)
