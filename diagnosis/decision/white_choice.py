"""The choice of an effect: the best on held-out data, or the simplest of those as good."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

from diagnosis.evidence.candidate_result import CandidateResult, with_outcomes
from diagnosis.evidence.held_out import Evidence
from diagnosis.library.candidates import Candidate
from diagnosis.library.drivers import may_drive
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects import BY_NAME, EFFECTS

CHAIN = tuple(BY_NAME)


@dataclass(frozen=True)
class Accepted:
    """An accepted effect, those that the data do not tell from it, and the evidence in nats that was needed.

    form_of : name of another that it could stand for: it takes what that one's form leaves, and is no second cause.
    """

    evidence: Evidence
    alternatives: tuple[str, ...]
    needed: float | None = None
    form_of: str | None = None

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.evidence.name

    def columns(self, problem: LinearProblem) -> Array:
        """Its columns (n, q, k)."""
        return self.evidence.candidate.columns(problem)


@dataclass(frozen=True)
class Round:
    """What a round of the loop chose, if anything, and every candidate as it was judged, the strongest first."""

    chosen: Accepted | None
    judged: tuple[CandidateResult, ...]

    @classmethod
    def of(cls, chosen: Accepted | None, judged: Sequence[CandidateResult]) -> Round:
        """A round whose candidates learn from the choice what came of them."""
        name, alternatives = (chosen.name, chosen.alternatives) if chosen else (None, ())
        return cls(chosen, with_outcomes(judged, name, alternatives))


def accepted(ranking: Sequence[Evidence], policy: Policy, *, clean: bool = True) -> Accepted | None:
    """The one with the fewest columns of those that the data do not tell from the best, if the best is accepted.

    clean : whether white noise is left; beside a colour more is needed.
    """
    needed = policy.accepted(len(EFFECTS)) if clean else policy.coloured_nats
    if not ranking or ranking[0].nats <= needed:
        return None
    best = ranking[0]
    as_good = [e for e in ranking if not e.behind(best, policy) or _is_it_too(e, best, policy)]
    close = [e for e in as_good if e.nats > policy.apart]
    chosen = simplest(close, policy)
    return Accepted(chosen, instead_of(chosen, close, policy), needed)


def instead_of(chosen: Evidence, close: Sequence[Evidence], policy: Policy) -> tuple[str, ...]:
    """Names of others that the data do not tell from the chosen one.

    What makes that one too is none of them unless it gains more than by chance: with nothing added it is the same.
    """

    def is_other(one: Evidence) -> bool:
        makes_it = chosen.name in one.candidate.effect.traits.contains
        return one.name != chosen.name and not (makes_it and not chosen.behind(one, policy))

    return tuple(dict.fromkeys(one.name for one in close if is_other(one)))


def beside_white_noise(ranking: Sequence[Evidence], policy: Policy) -> Round:
    """The choice where what is left is clean."""
    needed = policy.accepted(len(EFFECTS))
    return Round.of(accepted(ranking, policy), [CandidateResult(e, e.nats, needed, "") for e in ranking])


class Rival(Protocol):
    """A candidate with what it gains."""

    @property
    def candidate(self) -> Candidate:
        """The effect at its setting."""

    @property
    def gain(self) -> float:
        """Nats."""

    @property
    def width(self) -> int:
        """Number of columns."""

    @property
    def name(self) -> str:
        """The effect's name."""

    @property
    def off_size(self) -> float:
        """How far an effect without coefficients is from its own size."""


R = TypeVar("R", bound=Rival)


def simplest(close: Sequence[R], policy: Policy) -> R:
    """The strongest of those with the fewest columns; of two that are one and the same, the chain's first.

    Hard iron and a sensor's offset span the same columns: which of them gains more is a matter of the last bit. Others
    say of themselves that they are the same.
    """
    narrowest = min(e.width for e in close)
    rivals = [e for e in close if e.width == narrowest]
    best = max(rivals, key=lambda e: e.gain)
    if kin := [e for e in rivals if are_kin(e, best)]:
        return _of_kin(kin, policy)
    like = best.candidate.effect.traits.equivalent_to
    same = [e for e in rivals if e.name == like or math.isclose(e.gain, best.gain, rel_tol=policy.same_gain)]
    return min(same, key=lambda e: CHAIN.index(e.name))


def _of_kin(kin: Sequence[R], policy: Policy) -> R:
    """The one nearest to its own size, for a low-pass taken twice is a delay; of several as good the chain's last."""
    nearest = min(e.off_size for e in kin)
    near = [e for e in kin if e.off_size < nearest + policy.same_size]
    most = max(e.gain for e in near)
    return max((e for e in near if most - e.gain < policy.apart), key=lambda e: CHAIN.index(e.name))


def by_form_alone(one: Evidence, best: Evidence, share: float) -> bool:
    """Whether the best is of its kin or makes it too, and gains no more beyond it than a share, an error of form."""
    near = are_kin(one, best) or one.name in best.candidate.effect.traits.contains
    return near and one.gain > (1 - share) * best.gain


def of_one_course(one: Evidence, best: Evidence, policy: Policy) -> bool:
    """Whether the best is a slow offset in time, and one that a channel drives adds nearly as much in its place."""
    driven = may_drive(one.candidate.effect, best.candidate.effect)
    return driven and one.strength > policy.one_course * best.strength


def _is_it_too(one: Evidence, best: Evidence, policy: Policy) -> bool:
    return by_form_alone(one, best, policy.same_kin) or of_one_course(one, best, policy)


def are_kin(one: Rival, other: Rival) -> bool:
    """Whether two effects are the same to first order."""
    kin = one.candidate.effect.traits.family
    return bool(kin) and kin == other.candidate.effect.traits.family
