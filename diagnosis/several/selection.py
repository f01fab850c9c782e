"""Selection over several recordings: accept the effect of largest joint gain, with a noise model for each recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from diagnosis.decision.choice import (
    AcceptedEffect,
    baseline_with,
    in_same_family,
    is_as_good,
    is_form_by_size,
    residual_tests,
    select_simplest,
)
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.library.candidates import Candidate
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Transfer
from diagnosis.several.coefficients import pool_estimates
from diagnosis.several.common_effects import in_all
from diagnosis.several.pooled_effect import (
    CandidateInRecording,
    PooledEffect,
    columns_in,
    cross_predicted,
    estimates_of,
)
from diagnosis.several.transfer import assess_transfer
from diagnosis.workflow import Examination, Progress
from sim.effects import EFFECTS
from validation.signals.amplitude import rms

Settings = dict[str, list[Candidate]]
"""Settings of each effect by name."""


@dataclass(frozen=True, eq=False)
class PooledRecording:
    """A recording of the pool: its own diagnosis, and the baseline of accepted effects, by name.

    events: found by its own diagnosis, and not observable elsewhere: steps, and effects in a part of the run.
    own_effects: found by its own diagnosis, without events.
    """

    examination: Examination
    baseline: Baseline
    names: tuple[str, ...]
    events: tuple[AcceptedEffect, ...]
    own_effects: tuple[AcceptedEffect, ...]

    @classmethod
    def of(cls, examination: Examination) -> PooledRecording:
        """The recording with its own events in the baseline."""
        accepted = examination.selection.accepted
        events = tuple(effect for effect in accepted if effect.evidence.candidate.one_run)
        own = tuple(effect for effect in accepted if not effect.evidence.candidate.one_run)
        baseline = baseline_with(events, examination.selection.start)
        return cls(examination, baseline, tuple(event.name for event in events), events, own)

    @property
    def problem(self) -> LinearProblem:
        """The recording compared with the model."""
        return self.baseline.problem

    @cached_property
    def coloured(self) -> ColouredBaseline:
        """The baseline with its noise model."""
        return ColouredBaseline.of(self.problem, self.baseline.accepted_columns)

    @cached_property
    def clean(self) -> bool:
        """Whether the residual of the baseline is clean."""
        return residual_tests(self.baseline, self.names).clean

    def with_candidate(self, candidate: Candidate) -> PooledRecording:
        """The recording with a further effect in the baseline, where its causes are recorded."""
        columns = columns_in(candidate, self.problem)
        if columns is None:
            return self
        return replace(self, baseline=self.baseline.with_columns(columns), names=(*self.names, candidate.name))


def select_pooled(
    recordings: Sequence[PooledRecording], say: Progress
) -> tuple[list[PooledEffect], list[PooledEffect]]:
    """Select effects supported by several recordings; return them with the effects named by a single recording."""
    pool, accepted = Pool(tuple(recordings), _settings(recordings)), list[PooledEffect]()
    first = pool.coloured
    while len(accepted) < pool.policy.most_effects and not (accepted and pool.clean):
        say(f"all recordings together, round {len(accepted) + 1}")
        best = pool.best_effect()
        if best is None or (accepted and is_form_of(accepted, best, first)):
            break
        accepted.append(best)
        pool = pool.with_candidate(best.candidate)
    return accepted, pool.named_by_one(accepted)


def _settings(recordings: Sequence[PooledRecording]) -> Settings:
    """The settings of every effect accepted by a recording alone, or found best where none accepts the effect."""
    results = (result for recording in recordings for result in recording.examination.selection.results)
    accepted = (effect for recording in recordings for effect in recording.own_effects)
    best, own = Settings(), Settings()
    for settings, several in ((best, results), (own, accepted)):
        for candidate in dict.fromkeys(one.evidence.candidate for one in several):
            if not candidate.one_run:
                settings.setdefault(candidate.name, []).append(candidate)
    return best | own


@dataclass(frozen=True, eq=False)
class Pool:
    """Recordings beside the effects accepted so far, and the settings of all effects that they may share."""

    recordings: tuple[PooledRecording, ...]
    settings: Settings

    @property
    def policy(self) -> Policy:
        """The policy of the diagnosis."""
        return self.recordings[0].problem.policy

    @property
    def coloured(self) -> list[ColouredBaseline]:
        """The baselines with their noise models."""
        return [recording.coloured for recording in self.recordings]

    @property
    def clean(self) -> bool:
        """Whether every recording's residual is clean."""
        return all(recording.clean for recording in self.recordings)

    def with_candidate(self, candidate: Candidate) -> Pool:
        """The pool with a further effect accepted."""
        return replace(self, recordings=tuple(recording.with_candidate(candidate) for recording in self.recordings))

    def best_effect(self) -> PooledEffect | None:
        """The effect of largest gain that the recordings support together."""
        tried = self._screened()
        for pooled in sorted(tried, key=lambda candidate: -candidate.gain):
            coloured = not self.with_candidate(pooled.candidate).clean
            effect = self._assessed(pooled, coloured=coloured)
            if effect.transfer is not None:
                named = self._with_alternatives(effect, pooled, tried, coloured=coloured)
                if not self._contradicts(named):
                    return named
        return None

    def _screened(self) -> list[PooledEffect]:
        """Test the candidates of largest gain with the baselines' noise models, and all named by a recording."""
        likely = cross_predicted([setting for listed in self.settings.values() for setting in listed], self.coloured)
        best = {name: sorted(listed, key=lambda setting: -likely[setting]) for name, listed in self.settings.items()}
        order = sorted(best, key=lambda name: -likely[best[name][0]])[: self.policy.tried_coloured]
        own = {effect.name for recording in self.recordings for effect in recording.own_effects}
        return [PooledEffect.of(best[name], self.coloured) for name in dict.fromkeys([*order, *sorted(own)])]

    def _assessed(self, pooled: PooledEffect, *, coloured: bool) -> PooledEffect:
        """The candidate's transfer, tested next to effects of other names that a recording has by itself."""
        here, named = dict(pooled.here), []
        for i, recording in enumerate(self.recordings):
            others = [effect for effect in recording.own_effects if effect.name != pooled.name]
            if i in here:
                here[i] = here[i].beside([effect.columns(recording.problem) for effect in others])
            if len(others) < len(recording.own_effects):
                named.append(i)
        needed = self.policy.coloured_nats if coloured else self.policy.accepted_pooled(len(EFFECTS))
        return assess_transfer(replace(pooled, here=here), needed, named)

    def _contradicts(self, effect: PooledEffect) -> bool:
        """Whether half of the recordings able to show the effect alone exclude it by a rule of their own diagnosis."""
        names = {effect.name, *effect.alternatives}
        able = [self.recordings[i] for i in effect.here if effect.own_nats(i) > self.policy.coloured_nats]
        own = [{name for one in recording.own_effects for name in (one.name, *one.alternatives)} for recording in able]
        return bool(able) and 2 * sum(map(names.isdisjoint, own)) >= len(able)

    def _with_alternatives(
        self, effect: PooledEffect, best: PooledEffect, tried: Sequence[PooledEffect], *, coloured: bool
    ) -> PooledEffect:
        """Choose the simplest of the candidates as good as the best, with all look-alikes as alternatives.

        Where coefficients differ, the recordings together do not tell the look-alikes.
        """
        policy, alike = self.policy, [best.name, *fit_equally_well(effect, self.settings)]
        form = policy.same_family_coloured if coloured else policy.same_family
        as_good = (one for one in tried if is_as_good(one, best, policy, form, 0.0))
        closest = [one for one in as_good if one.name in alike or in_same_family(one, best)]
        simplest = self._assessed(select_simplest(closest, policy), coloured=coloured)
        last = effect if simplest.transfer is None else simplest
        names = dict.fromkeys([*(one.name for one in closest), *alike, *self._alike_in_each(last)])
        return replace(last, alternatives=tuple(name for name in names if name != last.name))

    def _alike_in_each(self, effect: PooledEffect) -> tuple[str, ...]:
        """Look-alikes of an effect whose coefficients differ, listed by every own diagnosis that names the effect."""
        if effect.transfer is not Transfer.NOT_TRANSFERRED:
            return ()
        own = (one for recording in self.recordings for one in recording.own_effects)
        return in_all([one.alternatives for one in own if one.name == effect.name])

    def named_by_one(self, accepted: Sequence[PooledEffect]) -> list[PooledEffect]:
        """Effects named by a single recording, tested next to the accepted effects."""
        known = {name for effect in accepted for name in (effect.name, *effect.alternatives)}
        own = {one.name: one.evidence.candidate for recording in self.recordings for one in recording.own_effects}
        tested = (PooledEffect.of([first], self.coloured) for name, first in own.items() if name not in known)
        return [replace(self._assessed(pooled, coloured=True), transfer=None) for pooled in tested]


def is_form_of(accepted: Sequence[PooledEffect], best: PooledEffect, first: Sequence[ColouredBaseline]) -> bool:
    """Whether an effect is a form error of accepted effects: of one family, or far smaller.

    first : the baselines without any effect. A size far smaller than alone shows resemblance to accepted effects.
    """
    if any(in_same_family(best, effect) for effect in accepted):
        return True
    same = any(best.name == effect.name for effect in accepted)
    alone = [CandidateInRecording.of(best.candidate, first[i], best.here[i].columns).strength for i in best.shown]
    return is_form_by_size(best.strength, rms(np.array(alone)), accepted[0].strength, best.policy, same=same)


def fit_equally_well(effect: PooledEffect, settings: Settings) -> list[str]:
    """Names of candidates that fit all data as well as an effect, in the noise that the effect leaves where present.

    Losses of many columns on held-out data, and prices of searches, guard against false names, not against look-alikes.
    A candidate containing the effect always fits as well; it is listed where it gains more than chance.
    """
    others = [candidate for listed in settings.values() for candidate in listed if candidate.name != effect.name]
    gains, close = _fitted_gains(effect, [effect.candidate, *others]), list[str]()
    for candidate in others:
        more = effect.policy.apart * effect.V * (1 if effect.name in candidate.effect.traits.contains else -1)
        close += [candidate.name] if gains.get(candidate, -np.inf) > gains[effect.candidate] + more else []
    return close


def _fitted_gains(effect: PooledEffect, candidates: Sequence[Candidate]) -> dict[Candidate, float]:
    """Nats explained in sample, with the effect's noise models, by candidates that all recordings with the effect hold.

    One coefficient vector for all recordings, or one for each where the effect's coefficients differ.
    """
    left, own = [effect.here[i].as_left for i in effect.shown], effect.transfer is Transfer.NOT_TRANSFERRED
    return {
        candidate: sum(one.gain(one.c) for one in (estimates if own else [pool_estimates(estimates)]))
        for candidate, estimates in estimates_of(candidates, left).items()
        if len(estimates) == len(left)
    }
