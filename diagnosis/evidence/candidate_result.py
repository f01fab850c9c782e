"""Result of a candidate in one round of the selection: evidence, evidence needed, outcome."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diagnosis.evidence.held_out import Evidence, on_six_digits

NAMED, BEHIND, TOO_LITTLE = "named", "explains less", "below what is needed"
INDISTINGUISHABLE, HARDLY_MORE = "cannot be distinguished from", "explains little more than"
WITHDRAWN, SMALL_SHARE = "withdrawn: ", "the named effects together explain too little of the gap"


@dataclass(frozen=True)
class CandidateResult:
    """A candidate with its evidence and the nats needed, under the noise model of the round; the outcome in words."""

    evidence: Evidence
    nats: float
    needed: float
    outcome: str

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.evidence.name


def with_outcomes(
    results: Sequence[CandidateResult], named: str | None, alternatives: Sequence[str]
) -> tuple[CandidateResult, ...]:
    """Candidates, strongest first, each with the outcome that follows from the choice of `named`."""

    def outcome(result: CandidateResult) -> str:
        rules = (
            (NAMED, result.name == named),
            (f"{INDISTINGUISHABLE} {named}", result.name in alternatives),
            (result.outcome, bool(result.outcome)),
            (TOO_LITTLE, result.nats <= result.needed),
            (f"{HARDLY_MORE} {named}", named in result.evidence.candidate.effect.traits.contains),
            (BEHIND, True),
        )
        return next(words for words, holds in rules if holds)

    told = (replace(result, outcome=outcome(result)) for result in results)
    return tuple(sorted(told, key=lambda result: -on_six_digits(result.nats)))


def withdraw_names(results: Sequence[CandidateResult], doubts: Sequence[str]) -> tuple[CandidateResult, ...]:
    """Candidates with the outcome of every name withdrawn, for doubts or because the names explain too little."""
    why = WITHDRAWN + ("; ".join(doubts) or SMALL_SHARE)
    named = {result.name for result in results if result.outcome == NAMED}
    alike = {f"{INDISTINGUISHABLE} {name}" for name in named}
    return tuple(
        replace(result, outcome=why) if result.name in named or result.outcome in alike else result
        for result in results
    )
