"""A candidate as it was judged in a round: its evidence, what was needed, and what came of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diagnosis.evidence.held_out import Evidence

NAMED, BEHIND, TOO_LITTLE = "named", "explains less", "below what is needed"
NOT_TOLD, AND_NO_MORE = "not told from", "and no more"
TAKEN_BACK, SMALL_SHARE = "not believed: ", "all names together explain too little of the gap"


@dataclass(frozen=True)
class CandidateResult:
    """A candidate with its evidence and the evidence needed, in nats beside the rest that the round judged by.

    outcome : what came of it, in words.
    """

    evidence: Evidence
    nats: float
    needed: float
    outcome: str

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.evidence.name


def with_outcomes(
    judged: Sequence[CandidateResult], named: str | None, alternatives: Sequence[str]
) -> tuple[CandidateResult, ...]:
    """Candidates, the strongest first, with what the choice of one of them says of each that has no outcome yet."""

    def outcome(one: CandidateResult) -> str:
        if one.name == named:
            return NAMED
        if one.name in alternatives:
            return f"{NOT_TOLD} {named}"
        if one.outcome or one.nats <= one.needed:
            return one.outcome or TOO_LITTLE
        return f"{named} {AND_NO_MORE}" if named in one.evidence.candidate.effect.traits.contains else BEHIND

    return tuple(sorted((replace(one, outcome=outcome(one)) for one in judged), key=lambda one: -one.nats))


def taken_back(judged: Sequence[CandidateResult], doubts: Sequence[str]) -> tuple[CandidateResult, ...]:
    """The same where no name is believed in the end, for a doubt or because they explain too little."""
    why = TAKEN_BACK + ("; ".join(doubts) or SMALL_SHARE)
    names = {one.name for one in judged if one.outcome == NAMED}
    alike = {f"{NOT_TOLD} {name}" for name in names}
    return tuple(replace(one, outcome=why) if one.name in names or one.outcome in alike else one for one in judged)
