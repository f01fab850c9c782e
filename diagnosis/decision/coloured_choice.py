"""Choice of an effect in coloured noise: each candidate is tested with a noise model of its own."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from diagnosis.decision.choice import AcceptedEffect, Selection, accept_simplest, is_as_good
from diagnosis.evidence.along_field import explains_along_field, gain_along_field, share_along_field
from diagnosis.evidence.baseline import Baseline, added_share
from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline, screen
from diagnosis.evidence.held_out import CandidateResult, Evidence
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
SMALL_SHARE_ADDED = "explains too little of the gap"
LOUDER_NOISE = "explained equally well by louder noise where it acts"
TURNS = {
    name for effect in EFFECTS if effect.traits.attitude_error for name in (effect.name, effect.traits.equivalent_to)
}
"""Names of the attitude errors, and of the effects equal to them on every motion."""
ATTITUDE_REFUSALS = (NO_GAIN_ALONG_FIELD, ATTITUDE_WANDER)
REVISABLE_REFUSALS = (*ATTITUDE_REFUSALS, LOSS_ALONG_FIELD, SIZE_DIFFERS)
"""Refusals that the residual of a second effect may have caused."""
FindNext = Callable[[Baseline, str], AcceptedEffect | None]
"""(baseline with an effect fitted, name of the effect) -> the next accepted effect."""


def choose_coloured(
    test: CandidateTest, candidates: Sequence[Evidence], windowed: Sequence[Evidence] = ()
) -> tuple[AcceptedEffect | None, list[CandidateResult]]:
    """Choose the candidate that beats a coloured noise model; with every candidate's result.

    A single noise model for all candidates would absorb an effect, or take one for granted. candidates : of one name, a
    later one replaces an earlier one where it gains more. windowed : candidates acting in a part of the run.
    """
    fits, screened = screen(candidates, test.beside, test.baseline, test.selection.start)
    fits = [*_stronger_in_window(windowed, fits, test), *fits]
    trials = _run_trials(test, fits)
    chosen, inflation, untested = None, trials[-1].inflation if trials else 1.0, fits[len(trials) :]
    if trials and not trials[-1].refusal:
        # candidates that were not tested have the inflation and the need of the accepted one
        trials += [replace(trials[-1], fit=fit) for fit in untested]
        chosen = _accepted_effect(trials[-len(untested) - 1 :], test.beside)
        if trials[-1].attitude_suffices:  # attitude errors are look-alikes
            chosen = chosen.listing(*(evidence.name for evidence in candidates if evidence.name in TURNS))
    needed = test.beside.rows.policy.coloured_nats
    results = [CandidateResult(one.fit.evidence, one.evidence.nats, one.needed, one.refusal) for one in trials]
    return chosen, [*results, *(CandidateResult(one, nats / inflation, needed, "") for one, nats in screened)]


def _stronger_in_window(
    windowed: Sequence[Evidence], tried: Sequence[CandidateFit], test: CandidateTest
) -> list[CandidateFit]:
    """Candidates in a window that gain far more than any candidate over the whole run, the strongest first."""
    policy, always = test.problem.policy, max((fit.gain for fit in tried), default=0.0)
    fits = [test.beside.fit_candidate(one, test.beside.columns_of(one.candidate)) for one in windowed]
    stronger = [fit for fit in fits if fit.gain > max(always / policy.window_share, always + policy.coloured_nats)]
    return sorted(stronger, key=lambda fit: -fit.gain)


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


@dataclass(frozen=True)
class CandidateTest:
    """The test that a round's candidates must pass beside the effects selected so far.

    find_next : finds a second effect next to a refused one.
    """

    selection: Selection
    find_next: FindNext | None = None

    @property
    def baseline(self) -> Baseline:
        """The baseline with the effects selected so far."""
        return self.selection.end

    @property
    def problem(self) -> LinearProblem:
        """The recording compared with the model."""
        return self.baseline.problem

    @cached_property
    def beside(self) -> ColouredBaseline:
        """The baseline with a coloured noise model."""
        return ColouredBaseline.of(self.problem, self.baseline.accepted_columns)

    @cached_property
    def wander(self) -> ColouredBaseline | None:
        """The coloured baseline with a wandering attitude added."""
        return with_attitude_wander(self.beside)

    def of(self, fit: CandidateFit) -> CandidateTrial:
        """Test one candidate: the first reason of any explanation without a name refuses it."""
        problem, policy, candidate = self.problem, self.problem.policy, fit.evidence.candidate
        after = self.baseline.with_columns(candidate.columns(problem))
        coloured = not self.selection.is_clean(after, candidate.name)
        needed = policy.coloured_nats if coloured else policy.accepted(len(EFFECTS))
        inflation, by_chance = self.beside.beyond_chance(fit, needed)
        reasons = itertools.chain(
            self._refusal_in_colour(fit, after) if coloured else (),
            self._refusal_along_the_field(fit, after, coloured),
            winning_rivals(fit, self.baseline, self.beside, coloured=coloured),
            self._refusal_by_wander(fit, after) if coloured else (),
        )
        refusal = by_chance or next(reasons, "")
        # a field that does nothing along the field may be a smooth attitude error
        may_be_attitude = candidate.effect.traits.field_source and not (refusal or coloured)
        across = may_be_attitude and not explains_along_field(self.baseline, after, candidate.tried)
        suffices = across and attitude_suffices(fit, self.baseline, self.beside)
        return CandidateTrial(fit, inflation, coloured, needed, refusal, suffices)

    def is_accepted_with_another(self, fit: CandidateFit, refusal: str) -> bool:
        """Whether a refused candidate is accepted together with the next effect, chosen with the candidate fitted.

        Of two effects the larger may be refused for the residual of the smaller: alone neither is accepted, together
        both are. Two effects on the field may both be pieces of an attitude error and do not support each other.
        """
        first, second = fit.evidence.candidate, None
        if self.find_next is not None:
            second = self.find_next(self.baseline.with_columns(first.columns(self.problem)), first.name)
        if second is None or second.name == first.name:
            return False
        stages = {first.effect.stage, second.evidence.candidate.effect.stage}
        if refusal in ATTITUDE_REFUSALS and stages == {"field"}:
            return False
        baseline = self.baseline.with_columns(second.columns(self.problem))
        test = CandidateTest(replace(self.selection, end=baseline))
        return not test.of(test.beside.fit_candidate(fit.evidence, fit.columns)).refusal

    def _refusal_in_colour(self, fit: CandidateFit, after: Baseline) -> Iterator[str]:
        """Low survival, as of what imitates attitude errors, a small share of the gap, and a burst of noise."""
        policy, needs = self.problem.policy, fit.evidence.candidate.effect.needs
        turns = self.problem.turns and not {"attitude", "rate"}.isdisjoint(needs)
        if turns and fit.evidence.survival < policy.hardly_any:
            yield NOT_SHOWN_BY_MOTION
        if added_share(self.selection.start, self.baseline, after.squares) < policy.trace:
            yield SMALL_SHARE_ADDED
        if self.beside.nats_in_its_own_noise(fit) <= policy.coloured_nats and after.left_of_last() > policy.trace:
            yield LOUDER_NOISE  # beside a trace of what the effect takes, its ends are not sharp

    def _refusal_along_the_field(self, fit: CandidateFit, after: Baseline, coloured: bool) -> Iterator[str]:
        """An error of the attitude: no gain along the field in a coloured residual, or a loss there in any."""
        problem, candidate = self.problem, fit.evidence.candidate
        source = candidate.effect.traits.field_source
        if problem.compares_across and (coloured or source):
            may_be_attitude = source or problem.level is not None  # errors of roll and pitch may explain all of the dip
            if coloured and may_be_attitude and not explains_along_field(self.baseline, after, candidate.tried):
                yield NO_GAIN_ALONG_FIELD
            if gain_along_field(self.baseline, after) < -problem.policy.apart:
                yield LOSS_ALONG_FIELD

    def _refusal_by_wander(self, fit: CandidateFit, after: Baseline) -> Iterator[str]:
        """A part of an attitude error; a source explaining enough along the field, where no wander is, is exempt."""
        policy, needed = self.problem.policy, self.problem.policy.coloured_nats
        source = fit.evidence.candidate.effect.traits.field_source and self.problem.compares_across
        enough = source and share_along_field(self.baseline, after) > policy.along_share
        exempt = enough and gain_along_field(self.baseline, after) > needed
        if not exempt and wander_wins(fit, self.wander, needed):
            yield ATTITUDE_WANDER


def _run_trials(test: CandidateTest, tried: Sequence[CandidateFit]) -> list[CandidateTrial]:
    """Test candidates in order up to the first accepted; the strongest, and of a wander, also with a second effect."""
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


def _accepted_effect(trials: Sequence[CandidateTrial], beside: ColouredBaseline) -> AcceptedEffect:
    """The first candidate, or the simplest of those as good, with the look-alikes; all useless beside the first."""
    (trial, *untested), policy = trials, beside.rows.policy
    best = trial.evidence
    as_good, alike = [best], list[Evidence]()
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
