"""What several recordings bear out, each with its value in every one of them and the test of their agreement."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.decision.monotone_courses import with_rivals
from diagnosis.decision.sentence import main_parameter
from diagnosis.decision.white_choice import Accepted
from diagnosis.evidence.held_out import Evidence
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import How, Named, Transfer
from diagnosis.several.coefficients import CoefficientEstimate, agreement, foretold, inverse, left_out_gains, size_over
from diagnosis.several.parameter_values import parameters_of
from diagnosis.several.selection import Chosen
from diagnosis.several.transfer import There, TransferFinding
from sim.effects import EFFECTS
from sim.effects.base import Effect
from validation.signals.amplitude import rms


@dataclass(frozen=True)
class Common:
    """One effect in n recordings: pooled, in each by itself (None: not known there), and whether they agree.

    chi2, degrees, p: of the differences between the recordings; None where nothing is fitted. ratios: of the size in
    each recording to that in the others, with its standard deviation.
    """

    named: Named
    each: tuple[Named | None, ...]
    there: tuple[There, ...]
    chi2: float | None
    degrees: int
    p: float | None
    ratios: tuple[tuple[float, float] | None, ...] = ()

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.named.name

    @property
    def several(self) -> bool:
        """Whether more than one shows it."""
        return self.reach is not Transfer.SINGLE_RUN

    @property
    def reach(self) -> Transfer:
        """Whether the recordings agree."""
        return self.named.evidence


def fitted_effect(one: Chosen, problems: Sequence[LinearProblem]) -> Common:
    """An effect of the library that the lot believes."""
    found = common_of(one.finding, one.alternatives, problems, one.strength)
    return replace(found, named=of_one_course(found, problems))


def of_one_course(one: Common, problems: Sequence[LinearProblem]) -> Named:
    """The name of an effect with the channels that go the same way as it does in every recording that has it."""
    there = [problem for problem, says in zip(problems, one.there, strict=True) if says is There.PRESENT]
    several = [with_rivals(problem, one.named).rivals for problem in there]
    return replace(one.named, rivals=_in_all(several)) if several else one.named


def not_borne_out(one: TransferFinding, problems: Sequence[LinearProblem]) -> Common:
    """An effect that one recording alone names."""
    return common_of(one, (), problems, 0.0)


def common_of(
    one: TransferFinding, alternatives: tuple[str, ...], problems: Sequence[LinearProblem], strength: float
) -> Common:
    """A finding as parameters: pooled, and in each recording by itself."""
    agree, candidate, reach = one.agreement, one.joint.candidate, one.reach or Transfer.SINGLE_RUN
    there = next(problem for problem, asked in zip(problems, one.joint.asked, strict=True) if asked)
    effect, spread = parameters_of(candidate, agree.c, agree.covariance, there)
    named = Named(effect, alternatives, How.HELD_OUT, one.nats, strength, spread, reach)
    each: list[Named | None] = []
    for problem, asked, own in zip(problems, one.joint.asked, one.joint.estimates, strict=True):
        if asked is None or own is None:
            each.append(None)
            continue
        effect, spread = parameters_of(candidate, own.c, own.covariance, problem)
        each.append(Named(effect, (), How.HELD_OUT, asked.held / asked.inflation, asked.strength, spread, reach))
    ratios = _ratios(one.joint.estimates)
    return Common(named, tuple(each), one.there, agree.chi2, agree.degrees, agree.p, ratios)


def _ratios(several: Sequence[CoefficientEstimate | None]) -> tuple[tuple[float, float] | None, ...]:
    """Size of each estimate over that of all others; None where one is missing or its course is not the others'."""
    there = [one for one in several if one is not None]
    pairs = zip(there, foretold(there), strict=True)
    found = iter(size_over(one, c) if 2 * one.scaled_gain(c) > one.scaled_gain(one.c) else None for one, c in pairs)
    return tuple(None if one is None else next(found) for one in several)


def changes_of_iron(several: Sequence[Sequence[Accepted]], problems: Sequence[LinearProblem]) -> list[Common]:
    """What of the iron differs from the model in more than one recording, by sizes that have something in common."""
    policy = problems[0].policy
    names = dict.fromkeys(one.name for found in several for one in found)
    by_name = {name: [next((one for one in found if one.name == name), None) for found in several] for name in names}
    return [_iron(each, problems, policy) for each in by_name.values() if _foretold(each, policy)]


def _foretold(each: Sequence[Accepted | None], policy: Policy) -> bool:
    """Whether the changes that the others show explain each by enough: the mean of a wander is another in every run."""
    estimates = [estimate_of(one.evidence) for one in each if one is not None]
    return float(left_out_gains(estimates).sum()) > policy.accepted_together(len(EFFECTS))


def _several(each: Iterable[object]) -> bool:
    return sum(one is not None for one in each) > 1


def _iron(each: Sequence[Accepted | None], problems: Sequence[LinearProblem], policy: Policy) -> Common:
    found = [one for one in each if one is not None]
    agree = agreement([estimate_of(one.evidence) for one in found], policy.same_coefficient)
    reach = _reach(agree.p > policy.not_transferred_alarm, each)
    nats, strength = sum(one.evidence.nats for one in found), rms(np.array([one.evidence.strength for one in found]))
    effect, spread = parameters_of(found[0].evidence.candidate, agree.c, agree.covariance, problems[0])
    named = Named(effect, _in_all([one.alternatives for one in found]), How.IRON, nats, strength, spread, reach)
    own = tuple(_iron_in_one(one, reach, problems[0]) for one in each)
    ratios = _ratios([None if one is None else estimate_of(one.evidence) for one in each])
    return Common(named, own, _marks(each), agree.chi2, agree.degrees, agree.p, ratios)


def _reach(same: bool, each: Sequence[object]) -> Transfer:
    """How far what some recordings show reaches, whether or not it is the same in them."""
    if not same:
        return Transfer.NOT_TRANSFERRED
    return Transfer.SOME if None in each else Transfer.TRANSFERRED


def _in_all(several: Sequence[tuple[str, ...]]) -> tuple[str, ...]:
    """Names that every list holds, in the order of the first."""
    return tuple(name for name in several[0] if all(name in other for other in several))


def _iron_in_one(one: Accepted | None, reach: Transfer, problem: LinearProblem) -> Named | None:
    if one is None:
        return None
    own = estimate_of(one.evidence)
    effect, spread = parameters_of(one.evidence.candidate, own.c, own.covariance, problem)
    return Named(effect, (), How.IRON, one.evidence.nats, one.evidence.strength, spread, reach)


def estimate_of(one: Evidence) -> CoefficientEstimate:
    """The coefficients of a candidate that is fitted in one recording, as information and score."""
    k = one.width
    N = inverse(one.fit.covariance[-k:, -k:] * max(one.V, 1.0))
    return CoefficientEstimate(N, N @ one.coefficients)


def seen_by_values(several: Sequence[Sequence[Named]], policy: Policy) -> list[Common]:
    """Noise, and what the values themselves show, in more than one recording: the same where their sizes are alike."""
    names = dict.fromkeys(one.name for found in several for one in found)
    by_name = {name: [next((one for one in found if one.name == name), None) for found in several] for name in names}
    return [_size(each, policy) for each in by_name.values() if _several(each)]


def _size(each: Sequence[Named | None], policy: Policy) -> Common:
    found = sorted((one for one in each if one is not None), key=lambda one: main_size(one.effect))
    alike = main_size(found[-1].effect) <= policy.stated_margin * main_size(found[0].effect)
    named = replace(found[len(found) // 2], evidence=_reach(alike, each))
    return Common(named, tuple(each), _marks(each), None, 0, None)


def _marks(each: Sequence[object]) -> tuple[There, ...]:
    return tuple(There.OPEN if one is None else There.PRESENT for one in each)


def main_size(effect: Effect) -> float:
    """Size of the parameter that says how large an effect is, in its unit."""
    return float(np.linalg.norm(np.asarray(getattr(effect, main_parameter(effect)), dtype=float)))
