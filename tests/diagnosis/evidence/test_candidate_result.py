"""What is said of each candidate of a round."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.evidence.held_out import (
    BEHIND,
    HARDLY_MORE,
    INDISTINGUISHABLE,
    NAMED,
    SMALL_SHARE,
    TOO_LITTLE,
    WITHDRAWN,
    CandidateResult,
    Evidence,
    with_outcomes,
    withdraw_names,
)
from diagnosis.library.candidates import Candidate
from sim.effects import EFFECTS
from sim.effects.base import Effect

FIVE = [effect for effect in EFFECTS if not effect.traits.contains][:5]
BEST, ALIKE, WEAKER, REFUSED, LEAST = FIVE


def _judged(number: int, nats: float, outcome: str = "", effect: type[Effect] | None = None) -> CandidateResult:
    none = np.zeros(3), np.zeros((3, 3)), 0.0, 0
    evidence = Evidence(Candidate(effect or FIVE[number]), nats, 1.0, 1.0, 1.0, nats, *none)
    return CandidateResult(evidence, nats, 25.0, outcome)


def test_every_candidate_learns_what_came_of_it() -> None:
    judged = [
        _judged(4, 3.0),
        _judged(2, 40.0),
        _judged(1, 97.0),
        _judged(3, 120.0, "next to nothing"),
        _judged(0, 99.0),
    ]
    told = {one.name: one.outcome for one in with_outcomes(judged, BEST.name, (ALIKE.name,))}
    assert list(told) == [REFUSED.name, BEST.name, ALIKE.name, WEAKER.name, LEAST.name]
    assert list(told.values()) == ["next to nothing", NAMED, f"{INDISTINGUISHABLE} {BEST.name}", BEHIND, TOO_LITTLE]


@pytest.mark.parametrize(
    ("nats", "outcome", "told"), [(40.0, "", HARDLY_MORE), (40.0, "odd", "odd"), (3.0, "", TOO_LITTLE)]
)
def test_what_makes_the_name_too_is_that_and_no_more(nats: float, outcome: str, told: str) -> None:
    richer = next(effect for effect in EFFECTS if effect.traits.contains)
    one, _ = with_outcomes([_judged(0, nats, outcome, richer), _judged(0, 1.0)], richer.traits.contains[0], ())
    assert one.outcome.startswith(told)


def test_a_name_that_is_not_believed_is_said_to_be_taken_back() -> None:
    judged = with_outcomes([_judged(0, 99.0), _judged(1, 98.0), _judged(4, 3.0)], BEST.name, (ALIKE.name,))
    assert [one.outcome for one in withdraw_names(judged, ())] == 2 * [WITHDRAWN + SMALL_SHARE] + [TOO_LITTLE]
    assert withdraw_names(judged, ("a channel is left",))[0].outcome == WITHDRAWN + "a channel is left"
