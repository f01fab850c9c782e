"""Of legs and look-alikes: which leg is flown, for what, and what no leg tells apart."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.next_leg.separation import LegProblem
from diagnosis.next_leg.table import LegTable
from tests.diagnosis.synthetic import problem

NAME: Any = SimpleNamespace(name="name")
LEGS: Any = ("first", "second")


def _pairs(*listed: bool) -> Any:
    return tuple(
        SimpleNamespace(listed=one, second=SimpleNamespace(name=name)) for one, name in zip(listed, "ab", strict=True)
    )


@pytest.mark.parametrize(
    ("nats", "listed", "best", "same"),
    [
        (((10.0, 4.0), (1.0, 3.0)), (True, True), ("second", "b", 3.0), ""),
        (((4.0, 10.0), (0.05, 0.02)), (True, True), ("second", "a", 10.0), "b"),
        (((10.0, 4.0), (1.0, 3.0)), (True, False), ("second", "a", 4.0), ""),
        (((10.0, 4.0), (0.05, 0.05)), (True, False), ("first", "a", 10.0), ""),
        (((0.05, 0.02), (1.0, 3.0)), (True, False), None, "a"),
        (((5.0, 0.0), (0.0, 5.0)), (True, True), None, ""),
    ],
)
def test_the_leg_that_tells_the_least_apart_best_is_flown(nats, listed, best, same) -> None:  # type: ignore[no-untyped-def]
    """What no leg tells apart does not choose it; what is no look-alike does, and is not told."""
    table = LegTable(NAME, _pairs(*listed), LEGS, np.array(nats), 0.1)
    assert table.best == best
    assert table.inseparable == tuple(("name", other) for other in same)


def test_nats_of_a_leg_are_those_of_the_hand_over_the_inflation() -> None:
    """With the effects that act always, and the iron refitted only where it is so in hand."""
    here, there = problem(n=300), problem(n=400)
    seen: list[Any] = []
    pair = SimpleNamespace(separation_nats=lambda leg: seen.append(leg) or 8.0)
    table = LegTable.of(NAME, LegProblem(here, ("always",), False), (pair,), [(LEGS[0], there)], 4.0)  # type: ignore[arg-type]
    assert table.nats.tolist() == [[2.0]]
    assert [(leg.problem is there, leg.permanent, leg.iron) for leg in seen] == [(True, ("always",), False)]


@pytest.mark.parametrize(("nats", "told"), [(0.08, []), (0.12, [0])])
def test_two_are_told_apart_by_a_tenth_of_a_nat(nats: float, told: list[int]) -> None:
    """A leg is flown as often as it takes, but not for ever."""
    here, pair = problem(n=300), SimpleNamespace(separation_nats=lambda leg: nats)
    assert LegTable.of(NAME, LegProblem(here, (), True), (pair,), [(LEGS[0], here)], 1.0).separable == told  # type: ignore[arg-type]
