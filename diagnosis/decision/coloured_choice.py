"""Choice of an effect in coloured noise: each candidate is tested with a noise model of its own."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from diagnosis.decision.choice import AcceptedEffect, accept_simplest, is_as_good
from diagnosis.evidence.along_field import explains_along_field, gain_along_field, share_along_field
from diagnosis.evidence.baseline import Baseline, IsClean, added_share
from diagnosis.evidence.candidate_result import TOO_LITTLE, CandidateResult
from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline, screen
from diagnosis.evidence.held_out import Evidence
from diagnosis.evidence.rivals import (
    ATTITUDE_WANDER,
    SIZE_DIFFERS,
    attitude_suffices,
    wander_wins,
    winning_rivals,
    with_attitude_wander,
)
from diagnosis.library.drivers import may_drive
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from sim.effects import EFFECTS

NO_GAIN_ALONG_FIELD = "no gain along the field: explained by an attitude error"
LOSS_ALONG_FIELD = "adds a part along the field that is not measured: explained by an attitude error"
NOT_SHOWN_BY_MOTION = "hardly observable on this motion: explained by attitude errors"
NO_BETTER_THAN_SURROGATES = "no better than its own course shifted in time"
SMALL_SHARE_ADDED = "explains too little of the gap"
TURNS = {
    name for effect in EFFECTS if effect.traits.attitude_error for name in (effect.name, effect.traits.equivalent_to)
}
"""Names of the attitude errors, and of the effects equal to them on every motion."""
ATTITUDE_REFUSALS = (NO_GAIN_ALONG_FIELD, ATTITUDE_WANDER)
REVISABLE_REFUSALS = (*ATTITUDE_REFUSALS, LOSS_ALONG_FIELD, SIZE_DIFFERS)
"""Refusals that the residual of a second effect may have caused."""
FindNext = Callable[[Baseline, Evidence], AcceptedEffect | None]
"""(baseline with an effect fitted, evidence of the effect) -> the next accepted effect."""
Round = tuple[AcceptedEffect | None, list[CandidateResult]]
"""The chosen effect of a round, if any, and every candidate's result, with the reason for a refusal."""


def choose_coloured(
    baseline: Baseline,
    ranking: Sequence[Evidence],
    start: Baseline,
    is_clean: IsClean,
    windowed: Sequence[Evidence] = (),
    fuller: Sequence[Evidence] = (),
    find_next: FindNext | None = None,
) -> Round:
    """Choose the candidate that beats a coloured noise model.

    A single noise model for all candidates would absorb an effect, or take one for granted. start : the baseline
    without effects, whose gap defines shares. windowed : candidates acting in a part of the run. fuller : candidates
    with a form from the start, each replacing the plain one where it gains more. find_next : finds a second effect next
    to a refused one.
    """
    beside = ColouredBaseline.of(baseline.problem, baseline.accepted_columns)
    fits, screened = screen([*ranking, *fuller], beside, baseline, start)
    fits = [*_stronger_in_window(windowed, fits, beside, baseline), *fits]
    trials = _run_trials(CandidateTest(baseline, beside, start, is_clean, find_next), fits)
    chosen, inflation = None, trials[-1].inflation if trials else 1.0
    results = [trial.result for trial in trials]
    if trials and not trials[-1].refusal:
        # candidates that were not tested have the inflation and the need of the accepted one
        untested = [replace(trials[-1], fit=fit) for fit in fits[len(trials) :]]
        results += [trial.result for trial in untested]
        chosen = _accepted_effect(trials[-1], untested, beside)
        if trials[-1].attitude_suffices:  # attitude errors are look-alikes
            chosen = chosen.listing(*(evidence.name for evidence in (*ranking, *fuller) if evidence.name in TURNS))
    needed = baseline.problem.policy.coloured_nats
    results += [CandidateResult(evidence, nats / inflation, needed, "") for evidence, nats in screened]
    return chosen, results


def _stronger_in_window(
    windowed: Sequence[Evidence], tried: Sequence[CandidateFit], beside: ColouredBaseline, baseline: Baseline
) -> list[CandidateFit]:
    """Candidates in a window that gain far more than any candidate over the whole run, the strongest first."""
    policy, always = baseline.problem.policy, max((fit.gain for fit in tried), default=0.0)
    columns = (beside.rows.bin(evidence.candidate.columns(baseline.problem)) for evidence in windowed)
    fits = map(beside.fit_candidate, windowed, columns)
    stronger = [fit for fit in fits if fit.gain > max(always / policy.window_share, always + policy.coloured_nats)]
    return sorted(stronger, key=lambda fit: -fit.gain)


def beyond_chance(
    fit: CandidateFit, beside: ColouredBaseline, problem: LinearProblem, needed: float
) -> tuple[float, str]:
    """Inflation of a candidate's nats by chance, and the reason why the nats are not beyond chance; empty if they are.

    Chance is what the candidate's columns, shifted in time, gain.
    """
    surrogates = beside.surrogate_gains(fit, problem)
    inflation = max(1.0, 2 * float(surrogates.mean()) / fit.columns.shape[2])
    by_chance = "" if fit.gain > surrogates.max() else NO_BETTER_THAN_SURROGATES
    return inflation, by_chance if fit.gain / inflation > needed else TOO_LITTLE


@dataclass(frozen=True)
class CandidateTrial:
    """Outcome of one candidate's test: inflation of evidence by chance, and reason of refusal (empty if accepted).

    attitude_suffices : an error of the attitude explains as much.
    """

    fit: CandidateFit
    inflation: float
    coloured: bool
    needed: float
    refusal: str
    attitude_suffices: bool = False

    @property
    def evidence(self) -> Evidence:
        """Evidence by the candidate's own noise model."""
        return replace(self.fit.evidence, gain=self.fit.gain, V=self.inflation)

    @property
    def result(self) -> CandidateResult:
        """The candidate's result, without the outcome that the choice decides."""
        return CandidateResult(self.fit.evidence, self.evidence.nats, self.needed, self.refusal)


@dataclass(frozen=True)
class CandidateTest:
    """The test that a round's candidates must pass: the baselines and the criteria of a clean residual."""

    baseline: Baseline
    coloured_baseline: ColouredBaseline
    start: Baseline
    is_clean: IsClean
    find_next: FindNext | None = None

    @cached_property
    def wander(self) -> ColouredBaseline | None:
        """The coloured baseline with a wandering attitude added."""
        return with_attitude_wander(self.coloured_baseline, self.baseline.problem)

    def of(self, fit: CandidateFit) -> CandidateTrial:
        """Test one candidate: the first reason of any explanation without a name refuses it."""
        problem, policy, candidate = self.baseline.problem, self.baseline.problem.policy, fit.evidence.candidate
        after = self.baseline.with_columns(candidate.columns(problem))
        coloured = not self.is_clean(after, fit.evidence.name)
        needed = policy.coloured_nats if coloured else policy.accepted(len(EFFECTS))
        inflation, by_chance = beyond_chance(fit, self.coloured_baseline, problem, needed)
        reasons = itertools.chain(
            self._refusal_in_colour(fit.evidence, after) if coloured else (),
            self._refusal_along_the_field(fit, after, coloured),
            winning_rivals(fit, self.baseline, self.coloured_baseline, coloured=coloured),
            self._refusal_by_wander(fit, after) if coloured else (),
        )
        refusal = by_chance or next(reasons, "")
        # a field that does nothing along the field may be a smooth attitude error
        may_be_attitude = candidate.effect.traits.field_source and not (refusal or coloured)
        across = may_be_attitude and not explains_along_field(self.baseline, after, candidate.tried)
        suffices = across and attitude_suffices(fit, self.baseline, self.coloured_baseline)
        return CandidateTrial(fit, inflation, coloured, needed, refusal, suffices)

    def is_accepted_with_another(self, fit: CandidateFit, refusal: str) -> bool:
        """Whether a refused candidate is accepted together with the next effect, chosen with the candidate fitted.

        Of two effects the larger may be refused for the residual of the smaller: alone neither is accepted, together
        both are. Two effects on the field may both be pieces of an attitude error and do not support each other.
        """
        problem, first, second = self.baseline.problem, fit.evidence.candidate, None
        if self.find_next is not None:
            second = self.find_next(self.baseline.with_columns(first.columns(problem)), fit.evidence)
        if second is None or second.name == first.name:
            return False
        stages = {first.effect.stage, second.evidence.candidate.effect.stage}
        if refusal in ATTITUDE_REFUSALS and stages == {"field"}:
            return False
        baseline = self.baseline.with_columns(second.columns(problem))
        beside = ColouredBaseline.of(problem, baseline.accepted_columns)
        test = CandidateTest(baseline, beside, self.start, self.is_clean)
        return not test.of(beside.fit_candidate(fit.evidence, fit.columns)).refusal

    def _refusal_in_colour(self, evidence: Evidence, after: Baseline) -> Iterator[str]:
        """Low survival, by which a candidate imitates attitude errors, and a small share of the gap."""
        problem = self.baseline.problem
        turns = problem.turns and not {"attitude", "rate"}.isdisjoint(evidence.candidate.effect.needs)
        if turns and evidence.survival < problem.policy.hardly_any:
            yield NOT_SHOWN_BY_MOTION
        if added_share(self.start, self.baseline, after.squares) < problem.policy.trace:
            yield SMALL_SHARE_ADDED

    def _refusal_along_the_field(self, fit: CandidateFit, after: Baseline, coloured: bool) -> Iterator[str]:
        """An error of the attitude: no gain along the field in a coloured residual, or a loss there in any."""
        problem, candidate = self.baseline.problem, fit.evidence.candidate
        source = candidate.effect.traits.field_source
        if problem.compares_across and (coloured or source):
            may_be_attitude = source or problem.level is not None  # errors of roll and pitch may explain all of the dip
            if coloured and may_be_attitude and not explains_along_field(self.baseline, after, candidate.tried):
                yield NO_GAIN_ALONG_FIELD
            if gain_along_field(self.baseline, after) < -problem.policy.apart:
                yield LOSS_ALONG_FIELD

    def _refusal_by_wander(self, fit: CandidateFit, after: Baseline) -> Iterator[str]:
        """A part of an attitude error; a source explaining enough along the field, where no wander is, is exempt."""
        policy, needed = after.problem.policy, after.problem.policy.coloured_nats
        source = fit.evidence.candidate.effect.traits.field_source and after.problem.compares_across
        enough = source and share_along_field(self.baseline, after) > policy.along_share
        exempt = enough and gain_along_field(self.baseline, after) > needed
        if not exempt and wander_wins(fit, self.wander, needed):
            yield ATTITUDE_WANDER


def _run_trials(test: CandidateTest, tried: Sequence[CandidateFit]) -> list[CandidateTrial]:
    """Test candidates in order up to the first accepted.

    The strongest candidate, and the strongest refused for a wandering attitude, are also tried with a second effect.
    """
    trials: list[CandidateTrial] = []
    for fit in tried:
        trial = test.of(fit)
        before = {previous.refusal for previous in trials}
        first = not before or (trial.refusal == ATTITUDE_WANDER and ATTITUDE_WANDER not in before)
        if first and trial.refusal in REVISABLE_REFUSALS and test.is_accepted_with_another(fit, trial.refusal):
            trial = replace(trial, refusal="")
        trials.append(trial)
        if not trial.refusal:
            break
    return trials


def _accepted_effect(
    trial: CandidateTrial, untested: Sequence[CandidateTrial], beside: ColouredBaseline
) -> AcceptedEffect:
    """The accepted candidate, or the simplest of those as good, with the look-alikes; all useless beside the best."""
    policy, best, alike = beside.rows.policy, trial.evidence, list[Evidence]()
    as_good = [best]
    if trial.coloured:
        form, simpler, near = policy.same_family_coloured, policy.same_family, policy.same_coloured
    else:
        form, near = policy.same_family, 0.0
        simpler = policy.same_family if trial.attitude_suffices else policy.same_constant
    for other in untested:
        evidence = other.evidence
        good, close = is_as_good(evidence, best, policy, form, simpler), best.gain - evidence.gain < near * best.gain
        useless = (good or close) and beside.remaining_share(other.fit, trial.fit) < policy.half
        if (good and useless) or is_channel_equivalent(evidence, best, policy):
            as_good.append(evidence)
        elif useless:
            alike.append(evidence)
    return accept_simplest(as_good, alike, trial.needed, policy)


def is_channel_equivalent(candidate: Evidence, best: Evidence, policy: Policy) -> bool:
    """Whether the best drifts slowly in time and a candidate driven by a channel adds nearly as much in its place."""
    is_driven = may_drive(candidate.candidate.effect, best.candidate.effect)
    return is_driven and candidate.strength > policy.nearly_all * best.strength
