"""Choice of an effect in white noise: the best on held-out data, or the simplest of equally good candidates."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar

from diagnosis.evidence.candidate_result import CandidateResult, with_outcomes
from diagnosis.evidence.held_out import Evidence
from diagnosis.library.candidates import Candidate
from diagnosis.library.drivers import may_drive
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects import BY_NAME, EFFECTS

CHAIN_ORDER = tuple(BY_NAME)


@dataclass(frozen=True)
class AcceptedEffect:
    """An accepted effect, its look-alikes, its evidence and the evidence needed, in nats.

    form_of : name of an accepted effect whose form error this effect fits; such an effect is no second cause.
    """

    evidence: Evidence
    alternatives: tuple[str, ...]
    needed: float | None = None
    form_of: str | None = None

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.evidence.name

    def columns(self, problem: LinearProblem) -> Array:
        """Columns (n, q, k) of the effect."""
        return self.evidence.candidate.columns(problem)

    def listing(self, *names: str) -> AcceptedEffect:
        """The effect with further look-alikes."""
        others = dict.fromkeys((*self.alternatives, *names))
        return replace(self, alternatives=tuple(name for name in others if name != self.name))


@dataclass(frozen=True)
class RoundResult:
    """Result of one round: the chosen effect, if any, and every candidate's result, the strongest first."""

    chosen: AcceptedEffect | None
    results: tuple[CandidateResult, ...]

    @classmethod
    def of(cls, chosen: AcceptedEffect | None, judged: Sequence[CandidateResult]) -> RoundResult:
        """Build a round whose candidates carry an outcome in words."""
        name, alternatives = (chosen.name, chosen.alternatives) if chosen else (None, ())
        return cls(chosen, with_outcomes(judged, name, alternatives))


def accept_best(ranking: Sequence[Evidence], policy: Policy, *, clean: bool = True) -> AcceptedEffect | None:
    """Accept the candidate with the fewest columns of all that are as good as the best, if the best has enough nats.

    clean : whether the residual is white; coloured noise needs more evidence.
    """
    needed = policy.accepted(len(EFFECTS)) if clean else policy.coloured_nats
    if not ranking or ranking[0].nats <= needed:
        return None
    best, form = ranking[0], policy.same_family
    alike = [evidence for evidence in ranking if is_as_good(evidence, best, policy, form, form)]
    close = [evidence for evidence in alike if evidence.nats > policy.apart]
    chosen = select_simplest(close, policy)
    return AcceptedEffect(chosen, alternatives_to(chosen, close, policy), needed)


def is_as_good(candidate: Evidence, best: Evidence, policy: Policy, form: float, simpler: float) -> bool:
    """Whether a candidate gains as much as the best but for chance, or but for a form error.

    form, simpler : share of the best gain by which the best's family, or an effect that the best contains, may gain
    less.
    """
    family = form if in_same_family(candidate, best) else 0.0
    contained = simpler if candidate.name in best.candidate.effect.traits.contains else 0.0
    return best.gain - candidate.gain <= max(policy.apart * best.V, max(family, contained) * best.gain)


def alternatives_to(chosen: Evidence, close: Sequence[Evidence], policy: Policy) -> tuple[str, ...]:
    """Names of effects that the data do not distinguish from the chosen effect.

    An effect that contains the chosen one is listed only where it gains more than chance: with its extra columns at
    zero both agree.
    """

    def is_alternative(evidence: Evidence) -> bool:
        contains_chosen = chosen.name in evidence.candidate.effect.traits.contains
        return evidence.name != chosen.name and not (contains_chosen and not chosen.is_behind(evidence, policy))

    return tuple(dict.fromkeys(evidence.name for evidence in close if is_alternative(evidence)))


def choose_white(ranking: Sequence[Evidence], policy: Policy) -> RoundResult:
    """Choose where the residual is white."""
    needed = policy.accepted(len(EFFECTS))
    return RoundResult.of(
        accept_best(ranking, policy), [CandidateResult(evidence, evidence.nats, needed, "") for evidence in ranking]
    )


class ComparableCandidate(Protocol):
    """A candidate with its gain and number of columns."""

    @property
    def candidate(self) -> Candidate:
        """The effect at its setting."""

    @property
    def gain(self) -> float:
        """Gain in nats."""

    @property
    def width(self) -> int:
        """Number of columns."""

    @property
    def name(self) -> str:
        """Name of the effect."""

    @property
    def scale_error(self) -> float:
        """``|ln(fitted size / own size)|`` of an effect without coefficients."""


R = TypeVar("R", bound=ComparableCandidate)


def select_simplest(close: Sequence[R], policy: Policy) -> R:
    """The strongest of the candidates with the fewest columns; of identical candidates, the first in the chain.

    Hard iron and sensor offset span the same columns: rounding decides which gains more. `Traits.equivalent_to`
    states further identities.
    """
    narrowest = min(candidate.width for candidate in close)
    rivals = [candidate for candidate in close if candidate.width == narrowest]
    best = max(rivals, key=lambda candidate: candidate.gain)
    if family := [candidate for candidate in rivals if in_same_family(candidate, best)]:
        return _select_in_family(family, policy)
    twin = best.candidate.effect.traits.equivalent_to
    identical = [
        candidate
        for candidate in rivals
        if candidate.name == twin or math.isclose(candidate.gain, best.gain, rel_tol=policy.same_gain)
    ]
    return min(identical, key=lambda candidate: CHAIN_ORDER.index(candidate.name))


def _select_in_family(family: Sequence[R], policy: Policy) -> R:
    """The family member nearest to its own size, else the last in the chain.

    Two low-passes in series resemble a delay.
    """
    nearest = min(candidate.scale_error for candidate in family)
    near = [candidate for candidate in family if candidate.scale_error < nearest + policy.same_size]
    most = max(candidate.gain for candidate in near)
    return max(
        (candidate for candidate in near if most - candidate.gain < policy.apart),
        key=lambda candidate: CHAIN_ORDER.index(candidate.name),
    )


def is_channel_equivalent(candidate: Evidence, best: Evidence, policy: Policy) -> bool:
    """Whether the best drifts slowly in time and a candidate driven by a channel adds nearly as much in its place."""
    is_driven = may_drive(candidate.candidate.effect, best.candidate.effect)
    return is_driven and candidate.strength > policy.nearly_all * best.strength


def in_same_family(first: ComparableCandidate, second: ComparableCandidate) -> bool:
    """Whether two effects agree to first order."""
    family = first.candidate.effect.traits.family
    return bool(family) and family == second.candidate.effect.traits.family


def is_form_by_size(strength: float, alone: float, first: float, policy: Policy, *, same: bool) -> bool:
    """Whether an effect is small enough for a form error of the first effect, given its strength alone.

    same : whether the effect was accepted before. A size far below that alone shows resemblance to accepted effects.
    """
    resembles = strength < policy.half * alone
    return strength < (policy.same_form_share if same or resembles else policy.form_share) * first
