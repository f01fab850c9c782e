"""Choice of an effect in coloured noise: each candidate is tested with a noise model of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from diagnosis.decision.screening import Screening
from diagnosis.decision.white_choice import (
    AcceptedEffect,
    RoundResult,
    alternatives_to,
    is_as_good,
    is_channel_equivalent,
    select_simplest,
)
from diagnosis.evidence.along_field import explains_along_field, gain_along_field, share_along_field
from diagnosis.evidence.baseline import Baseline, IsClean, added_share
from diagnosis.evidence.candidate_result import TOO_LITTLE, CandidateResult
from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline
from diagnosis.evidence.held_out import Evidence
from diagnosis.evidence.rivals import (
    ATTITUDE_WANDER,
    SIZE_DIFFERS,
    attitude_suffices,
    wander_wins,
    winning_rival,
    with_attitude_wander,
)
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


def choose_coloured(
    baseline: Baseline,
    ranking: Sequence[Evidence],
    start: Baseline,
    is_clean: IsClean,
    windowed: Sequence[Evidence] = (),
    fuller: Sequence[Evidence] = (),
    find_next: FindNext | None = None,
) -> RoundResult:
    """Choose the candidate that beats a coloured noise model.

    A single noise model for all candidates would absorb an effect, or take one for granted. start : the baseline
    without effects, whose gap defines shares. windowed : candidates acting in a part of the run. fuller : candidates
    with a form from the start, each replacing the plain one where it gains more. beyond : finds a second effect next to
    a refused one.
    """
    policy, beside = baseline.problem.policy, ColouredBaseline.of(baseline.problem, baseline.accepted_columns)
    screening = Screening.of([*ranking, *fuller], beside, baseline)
    order, most = screening.order(baseline, start), policy.tried_coloured
    tried = sorted((screening.best_fit(index, beside) for index in order[:most]), key=lambda fit: -fit.gain)
    tried = [*_stronger_in_window(windowed, tried, beside, baseline), *tried]
    trials = _run_trials(CandidateTest(baseline, beside, start, is_clean, find_next), tried)
    inflation = trials[-1].inflation if trials else 1.0
    screened = [
        CandidateResult(screening.candidates[i], float(screening.nats[i]) / inflation, policy.coloured_nats, "")
        for i in order[most:]
    ]
    chosen = _accepted_effect(trials, tried, beside, screening.candidates)
    return RoundResult.of(chosen, [*_results(trials, tried), *screened])


def _results(trials: Sequence[CandidateTrial], tried: Sequence[CandidateFit]) -> list[CandidateResult]:
    """Results of the fitted candidates; the untested ones have the inflation and the need of the last test."""
    tests = (trials[min(i, len(trials) - 1)] for i in range(len(tried)))
    return [
        CandidateResult(fit.evidence, fit.gain / test.inflation, test.needed, test.refusal if test.fit is fit else "")
        for fit, test in zip(tried, tests, strict=True)
    ]


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
    if fit.gain / inflation <= needed:
        return inflation, TOO_LITTLE
    return inflation, "" if fit.gain > surrogates.max() else NO_BETTER_THAN_SURROGATES


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

    def inflated(self, fit: CandidateFit) -> Evidence:
        """Evidence of a fit with the inflation of this test."""
        return replace(fit.evidence, gain=fit.gain, V=self.inflation)


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

    def is_accepted_with_another(self, fit: CandidateFit, refusal: str) -> bool:
        """Whether a refused candidate is accepted together with the next effect, chosen with the candidate fitted.

        Of two effects the larger may be refused for the residual of the smaller: alone neither is accepted, together
        both are. Two effects on the field may both be pieces of an attitude error and do not support each other.
        """
        problem = self.baseline.problem
        if self.find_next is None:
            return False
        second = self.find_next(self.baseline.with_columns(fit.evidence.candidate.columns(problem)), fit.evidence)
        if second is None or second.name == fit.evidence.name:
            return False
        if refusal in ATTITUDE_REFUSALS and _acts_on_field(second.evidence) and _acts_on_field(fit.evidence):
            return False
        baseline = self.baseline.with_columns(second.columns(problem))
        test = CandidateTest(
            baseline, ColouredBaseline.of(problem, baseline.accepted_columns), self.start, self.is_clean
        )
        return not test.of(test.coloured_baseline.fit_candidate(fit.evidence, fit.columns)).refusal

    def of(self, fit: CandidateFit) -> CandidateTrial:
        """Test one candidate."""
        policy = self.baseline.problem.policy
        with_candidate = self.baseline.with_columns(fit.evidence.candidate.columns(self.baseline.problem))
        coloured = not self.is_clean(with_candidate, fit.evidence.name)
        needed = policy.coloured_nats if coloured else policy.accepted(len(EFFECTS))
        inflation, refusal = beyond_chance(fit, self.coloured_baseline, self.baseline.problem, needed)
        refusal = refusal or self._refusal(fit, with_candidate, needed, coloured=coloured)
        turned = not (refusal or coloured) and self._is_attitude(fit, with_candidate)
        return CandidateTrial(fit, inflation, coloured, needed, refusal, turned)

    def _refusal(self, fit: CandidateFit, with_candidate: Baseline, needed: float, *, coloured: bool) -> str:
        """Reason why a candidate with enough evidence is no cause, empty if none."""
        return (
            (self._refusal_in_colour(fit.evidence, with_candidate) if coloured else "")
            or self._refusal_along_the_field(fit, with_candidate, coloured)
            or winning_rival(fit, self.baseline, self.coloured_baseline, coloured=coloured)
            or (self._refusal_by_wander(fit, with_candidate, needed) if coloured else "")
        )

    def _refusal_in_colour(self, evidence: Evidence, with_candidate: Baseline) -> str:
        """Refuse a candidate of low survival, which imitates attitude errors, and a small share of the gap."""
        problem = self.baseline.problem
        turns = problem.turns and not {"attitude", "rate"}.isdisjoint(evidence.candidate.effect.needs)
        if turns and evidence.survival < problem.policy.hardly_any:
            return NOT_SHOWN_BY_MOTION
        added = added_share(self.start, self.baseline, with_candidate.squares)
        return SMALL_SHARE_ADDED if added < problem.policy.trace else ""

    def _refusal_by_wander(self, fit: CandidateFit, with_candidate: Baseline, needed: float) -> str:
        """Refuse a part of an attitude error; a source explaining the part along the field is exempt."""
        source = fit.evidence.candidate.effect.traits.field_source and with_candidate.problem.compares_across
        if source and self._explains_along_field(with_candidate, needed):
            return ""
        return ATTITUDE_WANDER if wander_wins(fit, self.wander, needed) else ""

    def _explains_along_field(self, with_candidate: Baseline, needed: float) -> bool:
        """Whether the part along the field is explained by enough evidence; a wandering attitude has no such part."""
        enough = share_along_field(self.baseline, with_candidate) > with_candidate.problem.policy.along_share
        return enough and gain_along_field(self.baseline, with_candidate) > needed

    def _is_attitude(self, fit: CandidateFit, with_candidate: Baseline) -> bool:
        """Whether a candidate field does nothing along the field that a smooth attitude error would not do."""
        candidate = fit.evidence.candidate
        if not candidate.effect.traits.field_source or explains_along_field(
            self.baseline, with_candidate, candidate.tried
        ):
            return False
        return attitude_suffices(fit, self.baseline, self.coloured_baseline)

    def _refusal_along_the_field(self, fit: CandidateFit, with_candidate: Baseline, coloured: bool) -> str:
        """Refuse an error of the attitude: no gain along the field in a coloured residual, or a loss there in any."""
        problem, candidate = self.baseline.problem, fit.evidence.candidate
        source = candidate.effect.traits.field_source
        if not problem.compares_across or not (coloured or source):
            return ""
        may_be_attitude = source or problem.level is not None  # errors of roll and pitch may explain all of the dip
        if coloured and may_be_attitude and not explains_along_field(self.baseline, with_candidate, candidate.tried):
            return NO_GAIN_ALONG_FIELD
        if gain_along_field(self.baseline, with_candidate) < -problem.policy.apart:
            return LOSS_ALONG_FIELD
        return ""


def _acts_on_field(evidence: Evidence) -> bool:
    return evidence.candidate.effect.stage == "field"


def _run_trials(test: CandidateTest, tried: Sequence[CandidateFit]) -> list[CandidateTrial]:
    """Test candidates in order up to the first accepted.

    The strongest candidate, and the strongest refused for a wandering attitude, are also tried with a second effect.
    """
    trials: list[CandidateTrial] = []
    for fit in tried:
        trial = test.of(fit)
        first = fit is tried[0] or (
            trial.refusal == ATTITUDE_WANDER and all(previous.refusal != ATTITUDE_WANDER for previous in trials)
        )
        if first and trial.refusal in REVISABLE_REFUSALS and test.is_accepted_with_another(fit, trial.refusal):
            trial = replace(trial, refusal="")
        trials.append(trial)
        if not trial.refusal:
            break
    return trials


def _accepted_effect(
    trials: Sequence[CandidateTrial],
    tried: Sequence[CandidateFit],
    beside: ColouredBaseline,
    ranking: Sequence[Evidence],
) -> AcceptedEffect | None:
    """The accepted candidate, or the simplest of those as good, with its look-alikes.

    Attitude errors are look-alikes where these suffice.
    """
    if not trials or trials[-1].refusal:
        return None
    trial, policy = trials[-1], beside.rows.policy
    as_good, alike = _close_candidates(trial, tried[len(trials) :], beside)
    chosen = select_simplest(as_good, policy)
    accepted = AcceptedEffect(chosen, alternatives_to(chosen, [*as_good, *alike], policy), trial.needed)
    turns = (evidence.name for evidence in ranking if evidence.name in TURNS)
    return accepted.listing(*turns) if trial.attitude_suffices else accepted


def _close_candidates(
    trial: CandidateTrial, untested: Sequence[CandidateFit], beside: ColouredBaseline
) -> tuple[list[Evidence], list[Evidence]]:
    """The best with the candidates as good, and further look-alikes in coloured noise; all useless beside the best."""
    policy, best, gain = beside.rows.policy, trial.inflated(trial.fit), trial.fit.gain
    if trial.coloured:
        form, simpler, near = policy.same_family_coloured, policy.same_family, policy.same_coloured
    else:
        form, near = policy.same_family, 0.0
        simpler = policy.same_family if trial.attitude_suffices else policy.same_constant
    as_good, alike = [best], []
    for fit in untested:
        evidence = trial.inflated(fit)
        good, close = is_as_good(evidence, best, policy, form, simpler), gain - fit.gain < near * gain
        useless = (good or close) and beside.remaining_share(fit, trial.fit) < policy.half
        if (good and useless) or is_channel_equivalent(evidence, best, policy):
            as_good.append(evidence)
        elif useless:
            alike.append(evidence)
    return as_good, alike
