"""Which candidate stands, alone or beside another, and which are its look-alikes."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.decision.coloured_choice import (
    NO_GAIN_ALONG_FIELD,
    REVISABLE_REFUSALS,
    CandidateTest,
    CandidateTrial,
)
from diagnosis.decision.screening import Screening
from diagnosis.decision.selection import select
from diagnosis.evidence.candidate_result import TOO_LITTLE
from diagnosis.evidence.candidate_test import CandidateFit
from diagnosis.policy import STANDARD
from sim.effects import EFFECTS
from tests.diagnosis.synthetic import problem, recording
from tests.nightly import first_daily

ERROR = {"error_enu_nT": [60.0, -40.0, 20.0]}


@pytest.mark.parametrize("refusal", first_daily([TOO_LITTLE, NO_GAIN_ALONG_FIELD]))
def test_of_two_effects_each_may_stand_beside_the_other_alone(refusal: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The larger is refused for what the other leaves, and is in once that one is; of too little nothing is asked."""
    gradient = {"gradient_nT_m": [[0.4, -0.2, 0.1], [-0.2, 0.3, 0.5], [0.1, 0.5, -0.7]]}
    jump = {"time_s": 120.0, "step_nT": [6.0, -6.0, 3.0]}
    posed, of = problem(n=2000, hidden={"field_gradient": gradient, "offset_jump": jump}), CandidateTest.of

    def refusing(self: CandidateTest, one: CandidateFit) -> CandidateTrial:
        sole = not self.baseline.accepted_columns and one.evidence.name == "field_gradient"
        return replace(of(self, one), refusal=refusal) if sole else of(self, one)

    monkeypatch.setattr(CandidateTest, "of", refusing)
    first = [one.name for one in select(posed).accepted][:1]
    assert (first == ["field_gradient"]) is (refusal in REVISABLE_REFUSALS)


def test_one_that_is_refused_is_neither_named_nor_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    name = next(effect.name for effect in EFFECTS if any(p.name in ERROR for p in effect.parameters()))
    posed = problem(n=1500, hidden={name: ERROR})
    (first,) = select(posed).accepted
    tried, of = [], CandidateTest.of

    def refusing(self: CandidateTest, one: CandidateFit) -> CandidateTrial:
        tried.append(one.evidence.name)
        return replace(of(self, one), refusal="for a reason") if len(tried) == 1 else of(self, one)

    monkeypatch.setattr(CandidateTest, "of", refusing)
    found = select(posed).accepted
    assert tried[0] in {first.name, *first.alternatives}
    assert found
    assert tried[0] not in {found[0].name, *found[0].alternatives}


def test_what_explains_next_to_nothing_takes_no_turn() -> None:
    """Nats of a first look come from what fitted iron moves about too; squares do not."""
    start: Any = SimpleNamespace(squares=4000.0, problem=SimpleNamespace(target=np.zeros((500, 3)), policy=STANDARD))
    candidates: Any = [SimpleNamespace(name=f"{less}", squares=4000.0 - less) for less in (10.0, 2000.0, 500.0, 0.0)]
    look = Screening(candidates, (), np.zeros(4), np.array([490.0, 30.0, 50.0, 500.0]))
    assert look.order(start, start) == [2, 1, 3, 0]


def test_what_has_another_size_in_each_part_is_refused() -> None:
    """A current whose gain has another sign in the last quarter, beside a temperature that only rises."""
    given = recording(1500)
    assert given.current_A is not None
    gain = np.where(given.time_s < 0.75 * given.time_s[-1], 1.0, -1.0)
    posed = problem(replace(given, mag_nT=given.mag_nT + (gain * given.current_A[:, 0])[:, None] * [3.0, -2.0, 1.0]))
    accepted = select(posed).accepted
    assert "motor_current" not in [one.name for one in accepted if one.evidence.candidate.window is None]
