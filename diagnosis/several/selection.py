"""Selection over several recordings: accept the effect of largest joint gain, with a noise model for each recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from diagnosis.decision.choice import (
    AcceptedEffect,
    in_same_family,
    is_form_by_size,
    residual_tests,
    select_simplest,
)
from diagnosis.evidence.along_field import explains_along_field
from diagnosis.evidence.baseline import Baseline, added_share
from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.library.candidates import Candidate
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Transfer
from diagnosis.several.common_effects import in_all
from diagnosis.several.pooled_effect import CandidateInRecording, PooledEffect, columns_in, cross_predicted
from diagnosis.several.transfer import Settings, assess_transfer, fit_equally_well, look_alikes
from diagnosis.workflow import Examination, Progress
from sim.effects import EFFECTS
from validation.signals.amplitude import rms


@dataclass(frozen=True, eq=False)
class PooledRecording:
    """A recording of the pool: its own diagnosis, and baselines without effects, and with accepted ones.

    events: found by its own diagnosis, and not observable elsewhere: steps, and effects in a part of the run.
    own_effects: found by its own diagnosis, without events.
    """

    examination: Examination
    start: Baseline
    baseline: Baseline
    events: tuple[AcceptedEffect, ...]
    own_effects: tuple[AcceptedEffect, ...]

    @classmethod
    def of(cls, examination: Examination) -> PooledRecording:
        """The recording with its own events in the baseline."""
        start, accepted = examination.selection.start, examination.selection.accepted
        events = tuple(effect for effect in accepted if effect.evidence.candidate.one_run)
        own = tuple(effect for effect in accepted if not effect.evidence.candidate.one_run)
        baseline = start.with_all(event.columns(start.problem) for event in events)
        return cls(examination, start, baseline, events, own)

    @property
    def problem(self) -> LinearProblem:
        """The recording compared with the model."""
        return self.baseline.problem

    @cached_property
    def coloured(self) -> ColouredBaseline:
        """The baseline with its noise model."""
        return ColouredBaseline.of(self.problem, self.baseline.accepted_columns)

    def with_candidate(self, candidate: Candidate) -> PooledRecording:
        """The recording with a further effect in the baseline, where its causes are recorded."""
        columns = columns_in(candidate, self.problem)
        return self if columns is None else replace(self, baseline=self.baseline.with_columns(columns))


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
    """Recordings beside the effects accepted so far, and the settings of all effects that they may share.

    names: of the accepted effects.
    """

    recordings: tuple[PooledRecording, ...]
    settings: Settings
    names: tuple[str, ...] = ()

    @property
    def policy(self) -> Policy:
        """The policy of the diagnosis."""
        return self.recordings[0].problem.policy

    @property
    def coloured(self) -> list[ColouredBaseline]:
        """The baselines with their noise models."""
        return [recording.coloured for recording in self.recordings]

    @cached_property
    def clean(self) -> bool:
        """Whether every recording's residual is clean."""
        return all(
            residual_tests(recording.baseline, [*self.names, *(event.name for event in recording.events)]).clean
            for recording in self.recordings
        )

    def with_candidate(self, candidate: Candidate) -> Pool:
        """The pool with a further effect accepted."""
        recordings = tuple(recording.with_candidate(candidate) for recording in self.recordings)
        return replace(self, recordings=recordings, names=(*self.names, candidate.name))

    def best_effect(self) -> PooledEffect | None:
        """The effect of largest gain that the recordings support together."""
        tried, refused = self._screened(), list[PooledEffect]()
        for pooled in sorted(tried, key=lambda candidate: -candidate.gain):
            if any(better.explains(pooled.columns) for better in refused):
                continue  # explained by a better candidate, hence refused for the same reason
            after = self.with_candidate(pooled.candidate)
            effect = self._assessed(pooled, coloured=not after.clean)
            if self._supports(effect, after):
                named = self._with_alternatives(effect, pooled, tried, coloured=not after.clean)
                if not self._contradicts(named):
                    return named
            # A recording with another cause may show the cause of all: then the rivals of this candidate stay.
            if effect.here == pooled.here:
                refused.append(pooled)
        return None

    def _screened(self) -> list[PooledEffect]:
        """Test the candidates of largest gain with the baselines' noise models, and all named by a recording."""
        likely = cross_predicted([setting for listed in self.settings.values() for setting in listed], self.coloured)
        best = {name: sorted(listed, key=lambda setting: -likely[setting]) for name, listed in self.settings.items()}
        order = sorted(best, key=lambda name: -likely[best[name][0]])[: self.policy.tried_coloured]
        own = {effect.name for recording in self.recordings for effect in recording.own_effects}
        return [
            PooledEffect.of(best[name], self.coloured) for name in dict.fromkeys([*order, *sorted(own - {*self.names})])
        ]

    def _assessed(self, pooled: PooledEffect, *, coloured: bool) -> PooledEffect:
        """The candidate's transfer, tested next to effects of other causes that a recording has by itself."""
        here, named = dict(pooled.here), []
        for i, recording in enumerate(self.recordings):
            own = recording.own_effects
            others = [effect for effect in own if pooled.name not in (effect.name, *effect.alternatives)]
            competing = [effect for effect in others if not in_same_family(effect.evidence, pooled)]
            if i in here:
                here[i] = here[i].beside([effect.columns(recording.problem) for effect in competing])
            if any(effect.name == pooled.name for effect in own):
                named.append(i)
        needed = self.policy.coloured_nats if coloured else self.policy.accepted_pooled(len(EFFECTS))
        return assess_transfer(replace(pooled, here=here), needed, named)

    def _supports(self, effect: PooledEffect, after: Pool) -> bool:
        """Whether the recordings support an effect beyond chance; after : the pool with the effect.

        In coloured noise an effect explains a share of the gap as well, and a source gains along the field in at least
        half of the recordings.
        """
        if effect.transfer is None or effect.nats <= effect.surrogate_gain():
            return False
        if after.clean:
            return True
        pairs = [(self.recordings[i], after.recordings[i].baseline) for i in effect.present]
        shares = [added_share(before.start, before.baseline, then.squares) for before, then in pairs]
        source = effect.candidate.effect.traits.field_source
        vector = [pair for pair in pairs if source and pair[0].problem.mode == "vector"]
        along = sum(explains_along_field(before.baseline, then) for before, then in vector)
        return sum(shares) / max(len(shares), 1) >= self.policy.trace and 2 * along >= len(vector)

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

        Where coefficients differ, the recordings together do not tell the look-alikes: those that every recording lists
        whose own diagnosis names the effect are added.
        """
        closest, alike = look_alikes(best, tried, coloured=coloured)
        names = [*(one.name for one in (*closest, *alike)), *fit_equally_well(effect, self.settings)]
        simplest = select_simplest(closest, best.policy)
        simpler = effect if simplest is best else self._assessed(simplest, coloured=coloured)
        last = effect if simpler.transfer is None else simpler
        if last.transfer is Transfer.NOT_TRANSFERRED:
            own = (one for recording in self.recordings for one in recording.own_effects)
            names += in_all([one.alternatives for one in own if one.name == last.name])
        return replace(last, alternatives=tuple(name for name in dict.fromkeys(names) if name != last.name))

    def named_by_one(self, accepted: Sequence[PooledEffect]) -> list[PooledEffect]:
        """Effects named by a single recording, tested next to the accepted effects."""
        known = {name for effect in accepted for name in (effect.name, *effect.alternatives)}
        own = {one.name: one.evidence.candidate for recording in self.recordings for one in recording.own_effects}
        alone = [dict.fromkeys([first, *self.settings[name]]) for name, first in own.items() if name not in known]
        tested = (PooledEffect.of(list(settings), self.coloured) for settings in alone)
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
