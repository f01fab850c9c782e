"""Effects common to several recordings, with their values in each and the test of agreement."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.decision.monotone_courses import with_rival_channels
from diagnosis.decision.sentence import main_parameter
from diagnosis.decision.white_choice import AcceptedEffect
from diagnosis.evidence.held_out import Evidence
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import EvidenceKind, NamedEffect, Transfer
from diagnosis.several.coefficients import (
    CoefficientEstimate,
    agreement,
    cross_predicted_gains,
    inverse,
    predicted_by_others,
    size_ratio,
)
from diagnosis.several.parameter_values import parameters_of
from diagnosis.several.selection import PooledEffect
from diagnosis.several.transfer import Presence, TransferFinding
from sim.effects import EFFECTS
from sim.effects.base import Effect
from validation.signals.amplitude import rms


@dataclass(frozen=True)
class CommonEffect:
    """One effect in n recordings: pooled, in each recording by itself (None: unknown), and the test of agreement.

    chi2, degrees, p: of the differences between recordings; None for effects without fitted coefficients. ratios: size
    in each recording over the size in all other recordings, with standard deviation.
    """

    named: NamedEffect
    each: tuple[NamedEffect | None, ...]
    presence: tuple[Presence, ...]
    chi2: float | None
    degrees: int
    p: float | None
    ratios: tuple[tuple[float, float] | None, ...] = ()

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.named.name

    @property
    def several(self) -> bool:
        """Whether more than one recording shows the effect."""
        return self.transfer is not Transfer.SINGLE_RUN

    @property
    def transfer(self) -> Transfer:
        """Whether the recordings agree."""
        return self.named.transfer


def common_fitted_effect(effect: PooledEffect, problems: Sequence[LinearProblem]) -> CommonEffect:
    """The common effect of an accepted effect of the pool."""
    common = common_effect(effect.finding, effect.alternatives, problems, effect.strength)
    return replace(common, named=with_common_rivals(common, problems))


def with_common_rivals(common: CommonEffect, problems: Sequence[LinearProblem]) -> NamedEffect:
    """The named effect with the rival channels of all recordings that show it."""
    present = [
        problem for problem, presence in zip(problems, common.presence, strict=True) if presence is Presence.PRESENT
    ]
    rivals = [with_rival_channels(problem, common.named).rivals for problem in present]
    return replace(common.named, rivals=_in_all(rivals)) if rivals else common.named


def single_effect(finding: TransferFinding, problems: Sequence[LinearProblem]) -> CommonEffect:
    """An effect named by a single recording."""
    return common_effect(finding, (), problems, 0.0)


def common_effect(
    finding: TransferFinding, alternatives: tuple[str, ...], problems: Sequence[LinearProblem], strength: float
) -> CommonEffect:
    """The parameters of a finding: pooled, and in each recording by itself."""
    agree, candidate, transfer = finding.agreement, finding.pooled.candidate, finding.transfer or Transfer.SINGLE_RUN
    there = next(
        problem for problem, in_recording in zip(problems, finding.pooled.in_recordings, strict=True) if in_recording
    )
    effect, spread = parameters_of(candidate, agree.c, agree.covariance, there)
    named = NamedEffect(effect, alternatives, EvidenceKind.HELD_OUT, finding.nats, strength, spread, transfer)
    each: list[NamedEffect | None] = []
    for problem, in_recording, estimate in zip(
        problems, finding.pooled.in_recordings, finding.pooled.estimates, strict=True
    ):
        if in_recording is None or estimate is None:
            each.append(None)
            continue
        effect, spread = parameters_of(candidate, estimate.c, estimate.covariance, problem)
        each.append(
            NamedEffect(
                effect,
                (),
                EvidenceKind.HELD_OUT,
                in_recording.held_out_gain / in_recording.inflation,
                in_recording.strength,
                spread,
                transfer,
            )
        )
    ratios = _ratios(finding.pooled.estimates)
    return CommonEffect(named, tuple(each), finding.presence, agree.chi2, agree.degrees, agree.p, ratios)


def _ratios(estimates: Sequence[CoefficientEstimate | None]) -> tuple[tuple[float, float] | None, ...]:
    """Size of each estimate over the size of all others; None for a missing estimate or a differing direction."""
    known = [estimate for estimate in estimates if estimate is not None]
    pairs = zip(known, predicted_by_others(known), strict=True)
    ratios = iter(
        size_ratio(estimate, c) if 2 * estimate.scaled_gain(c) > estimate.scaled_gain(estimate.c) else None
        for estimate, c in pairs
    )
    return tuple(None if estimate is None else next(ratios) for estimate in estimates)


def common_iron_changes(
    changes_of_each: Sequence[Sequence[AcceptedEffect]], problems: Sequence[LinearProblem]
) -> list[CommonEffect]:
    """Changes of the iron found in more than one recording, with sizes predicting each other."""
    policy = problems[0].policy
    names = dict.fromkeys(change.name for changes in changes_of_each for change in changes)
    by_name = {
        name: [next((change for change in changes if change.name == name), None) for changes in changes_of_each]
        for name in names
    }
    return [
        _common_iron(changes_of_name, problems, policy)
        for changes_of_name in by_name.values()
        if _is_predicted(changes_of_name, policy)
    ]


def _is_predicted(changes: Sequence[AcceptedEffect | None], policy: Policy) -> bool:
    """Whether each change is predicted by the others with enough gain: the mean of a wander differs from run to run."""
    estimates = [estimate_from(change.evidence) for change in changes if change is not None]
    return float(cross_predicted_gains(estimates).sum()) > policy.accepted_pooled(len(EFFECTS))


def _in_several(values: Iterable[object]) -> bool:
    return sum(value is not None for value in values) > 1


def _common_iron(
    changes: Sequence[AcceptedEffect | None], problems: Sequence[LinearProblem], policy: Policy
) -> CommonEffect:
    known = [change for change in changes if change is not None]
    agree = agreement([estimate_from(change.evidence) for change in known], policy.same_coefficient)
    transfer = _transfer_of(agree.p > policy.not_transferred_alarm, changes)
    nats, strength = (
        sum(change.evidence.nats for change in known),
        rms(np.array([change.evidence.strength for change in known])),
    )
    first, there = next(
        (change, problem) for change, problem in zip(changes, problems, strict=True) if change is not None
    )
    effect, spread = parameters_of(first.evidence.candidate, agree.c, agree.covariance, there)
    named = NamedEffect(
        effect, _in_all([change.alternatives for change in known]), EvidenceKind.IRON, nats, strength, spread, transfer
    )
    own = tuple(_iron_in_recording(*one, transfer) for one in zip(changes, problems, strict=True))
    ratios = _ratios([None if change is None else estimate_from(change.evidence) for change in changes])
    return CommonEffect(named, own, _presences(changes), agree.chi2, agree.degrees, agree.p, ratios)


def _transfer_of(agree: bool, values: Sequence[object]) -> Transfer:
    """How far an effect seen in some recordings transfers, given whether its sizes agree."""
    if not agree:
        return Transfer.NOT_TRANSFERRED
    return Transfer.SOME if None in values else Transfer.TRANSFERRED


def _in_all(lists: Sequence[tuple[str, ...]]) -> tuple[str, ...]:
    """Names in every list, in the order of the first."""
    return tuple(name for name in lists[0] if all(name in other for other in lists))


def _iron_in_recording(change: AcceptedEffect | None, problem: LinearProblem, transfer: Transfer) -> NamedEffect | None:
    if change is None:
        return None
    own = estimate_from(change.evidence)
    effect, spread = parameters_of(change.evidence.candidate, own.c, own.covariance, problem)
    return NamedEffect(effect, (), EvidenceKind.IRON, change.evidence.nats, change.evidence.strength, spread, transfer)


def estimate_from(evidence: Evidence) -> CoefficientEstimate:
    """Coefficients of a candidate fitted in one recording, as information and score."""
    k = evidence.width
    N = inverse(evidence.fit.covariance[-k:, -k:] * max(evidence.V, 1.0))
    return CoefficientEstimate(N, N @ evidence.coefficients)


def common_value_effects(effects_of_each: Sequence[Sequence[NamedEffect]], policy: Policy) -> list[CommonEffect]:
    """Noise and direct evidence in more than one recording, common where the sizes are alike."""
    names = dict.fromkeys(effect.name for effects in effects_of_each for effect in effects)
    by_name = {
        name: [next((effect for effect in effects if effect.name == name), None) for effects in effects_of_each]
        for name in names
    }
    return [
        _common_value_effect(effects_of_name, policy)
        for effects_of_name in by_name.values()
        if _in_several(effects_of_name)
    ]


def _common_value_effect(effects: Sequence[NamedEffect | None], policy: Policy) -> CommonEffect:
    known = sorted((effect for effect in effects if effect is not None), key=lambda effect: main_size(effect.effect))
    alike = main_size(known[-1].effect) <= policy.somewhat_larger * main_size(known[0].effect)
    named = replace(known[len(known) // 2], transfer=_transfer_of(alike, effects))
    return CommonEffect(named, tuple(effects), _presences(effects), None, 0, None)


def _presences(values: Sequence[object]) -> tuple[Presence, ...]:
    return tuple(Presence.UNDECIDED if value is None else Presence.PRESENT for value in values)


def main_size(effect: Effect) -> float:
    """Size of the main parameter of an effect, in its unit."""
    return float(np.linalg.norm(np.asarray(getattr(effect, main_parameter(effect)), dtype=float)))
