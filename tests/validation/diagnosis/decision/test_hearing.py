"""Candidates that were refused are no look-alikes of the one that stands."""

from __future__ import annotations

from dataclasses import replace

import pytest

from sim.effects import EFFECTS
from tests.validation.diagnosis.synthetic import problem
from validation.diagnosis.decision.hearing import Hearing, Trial
from validation.diagnosis.decision.selection import select
from validation.diagnosis.evidence.standing import Standing

ERROR = {"error_enu_nT": [60.0, -40.0, 20.0]}


def test_one_that_is_refused_is_neither_named_nor_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    name = next(effect.name for effect in EFFECTS if any(p.name in ERROR for p in effect.parameters()))
    posed = problem(n=1500, hidden={name: ERROR})
    (first,) = select(posed).found
    tried, of = [], Hearing.of

    def refusing(self: Hearing, one: Standing) -> Trial:
        tried.append(one.evidence.name)
        return replace(of(self, one), refusal="for a reason") if len(tried) == 1 else of(self, one)

    monkeypatch.setattr(Hearing, "of", refusing)
    found = select(posed).found
    assert tried[0] in {first.name, *first.alternatives}
    assert found
    assert tried[0] not in {found[0].name, *found[0].alternatives}
