"""Selection over several recordings: accept the effect of largest joint gain, with a noise model for each recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from diagnosis.decision.choice import AcceptedEffect, in_same_family, is_form_by_size, select_simplest
from diagnosis.decision.selection import residual_tests
from diagnosis.evidence.along_field import explains_along_field
from diagnosis.evidence.baseline import Baseline, added_share
from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.library.candidates import Candidate
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Transfer
from diagnosis.several.common_effects import in_all
from diagnosis.several.pooled_test import (
    CandidateInRecording,
    PooledCandidate,
    Posed,
    columns_in,
    cross_predicted,
)
from diagnosis.several.transfer import PooledEffect, Settings, assess_transfer, fit_equally_well, look_alikes
from diagnosis.workflow import Examination, Progress
from sim.effects import EFFECTS


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
        start, accepted = examination.conclusion.selection.start, examination.conclusion.accepted
        events = tuple(effect for effect in accepted if effect.evidence.candidate.one_run)
        own = tuple(effect for effect in accepted if not effect.evidence.candidate.one_run)
        baseline = start.with_all(event.columns(start.problem) for event in events)
        return cls(examination, start, baseline, events, own)

    @property
    def problem(self) -> LinearProblem:
        """The recording compared with the model."""
        return self.baseline.problem

    @cached_property
    def posed(self) -> Posed:
        """The problem, and the baseline with its noise model."""
        return self.problem, ColouredBaseline.of(self.problem, self.baseline.accepted_columns)

    def with_candidate(self, candidate: Candidate) -> PooledRecording:
        """The recording with a further effect in the baseline, where its causes are recorded."""
        columns = columns_in(candidate, self.problem)
        return self if columns is None else replace(self, baseline=self.baseline.with_columns(columns))


def select_pooled(
    recordings: Sequence[PooledRecording], say: Progress
) -> tuple[list[PooledEffect], list[PooledEffect]]:
    """Select effects supported by several recordings; return them with the effects named by a single recording."""
    policy, settings, accepted = recordings[0].problem.policy, _settings(recordings), list[PooledEffect]()
    first = [recording.posed for recording in recordings]
    while len(accepted) < policy.most_effects and not (accepted and _residuals_are_clean(recordings, accepted)):
        say(f"all recordings together, round {len(accepted) + 1}")
        best = _best_candidate(recordings, settings, accepted)
        if best is None or (accepted and is_form_of(accepted, best, first)):
            break
        accepted.append(best)
        recordings = [recording.with_candidate(best.pooled.candidate) for recording in recordings]
    return accepted, _named_by_one(recordings, settings, accepted)


def _settings(recordings: Sequence[PooledRecording]) -> Settings:
    """The settings of every effect accepted by a recording alone, or found best where none accepts the effect."""
    results = (result for recording in recordings for result in recording.examination.conclusion.selection.results)
    accepted = (effect for recording in recordings for effect in recording.own_effects)
    best, own = Settings(), Settings()
    for settings, several in ((best, results), (own, accepted)):
        for candidate in dict.fromkeys(one.evidence.candidate for one in several):
            if not candidate.one_run:
                settings.setdefault(candidate.name, []).append(candidate)
    return best | own


def _residuals_are_clean(
    recordings: Sequence[PooledRecording], effects: Sequence[PooledEffect | PooledCandidate]
) -> bool:
    names = [effect.name for effect in effects]
    return all(
        residual_tests(recording.baseline, [*names, *(event.name for event in recording.events)]).clean
        for recording in recordings
    )


def _best_candidate(
    recordings: Sequence[PooledRecording], settings: Settings, accepted: Sequence[PooledEffect]
) -> PooledEffect | None:
    """The most likely candidate supported by the recordings together."""
    tried, refused = _screened(recordings, settings, accepted), list[PooledCandidate]()
    for pooled in sorted(tried, key=lambda candidate: -candidate.gain):
        if any(better.explains(pooled.columns) for better in refused):
            continue  # explained by a better candidate, hence refused for the same reason
        with_candidate = [recording.with_candidate(pooled.candidate) for recording in recordings]
        coloured = not _residuals_are_clean(with_candidate, [*accepted, pooled])
        effect = _assessed(pooled, recordings, coloured=coloured)
        if _is_supported(effect, recordings, with_candidate, coloured=coloured):
            named = _with_alternatives(effect, pooled, tried, settings, recordings, coloured=coloured)
            if not _is_contradicted(named, recordings):
                return named
        # A recording with another cause may show the cause of all: then the rivals of this candidate stay.
        if effect.pooled.here == pooled.here:
            refused.append(pooled)
    return None


def _screened(
    recordings: Sequence[PooledRecording], settings: Settings, accepted: Sequence[PooledEffect]
) -> list[PooledCandidate]:
    """Test the candidates of largest gain with the baselines' noise models, and all effects named by a recording."""
    posed = [recording.posed for recording in recordings]
    likely = cross_predicted([setting for listed in settings.values() for setting in listed], posed)
    best = {name: sorted(listed, key=lambda setting: -likely[setting]) for name, listed in settings.items()}
    order = sorted(best, key=lambda name: -likely[best[name][0]])[: recordings[0].problem.policy.tried_coloured]
    own_names = {effect.name for recording in recordings for effect in recording.own_effects}
    names = dict.fromkeys([*order, *sorted(own_names - {effect.name for effect in accepted})])
    return [PooledCandidate.of(best[name], posed) for name in names]


def _assessed(pooled: PooledCandidate, recordings: Sequence[PooledRecording], *, coloured: bool) -> PooledEffect:
    """The candidate's transfer, tested next to effects that a recording has by itself and that compete.

    Competing effects are of a different family, and do not list the candidate as a look-alike.
    """
    policy, here, named = recordings[0].problem.policy, dict(pooled.here), []
    for i, recording in enumerate(recordings):
        own = recording.own_effects
        others = [effect for effect in own if pooled.name not in (effect.name, *effect.alternatives)]
        competing = [effect for effect in others if not in_same_family(effect.evidence, pooled)]
        if i in here:
            here[i] = here[i].beside([effect.columns(recording.problem) for effect in competing])
        if any(effect.name == pooled.name for effect in own):
            named.append(i)
    needed = policy.coloured_nats if coloured else policy.accepted_pooled(len(EFFECTS))
    return assess_transfer(replace(pooled, here=here), needed, named)


def _is_supported(
    effect: PooledEffect,
    recordings: Sequence[PooledRecording],
    with_candidate: Sequence[PooledRecording],
    *,
    coloured: bool,
) -> bool:
    """Whether the recordings support an effect beyond chance.

    In coloured noise an effect explains a share of the gap as well, and a source gains along the field in at least half
    of the recordings.
    """
    if effect.transfer is None or effect.nats <= effect.pooled.surrogate_gain():
        return False
    if not coloured:
        return True
    pairs, traits = [(recordings[i], with_candidate[i]) for i in effect.present], effect.pooled.candidate.effect.traits
    shares = [added_share(before.start, before.baseline, after.baseline.squares) for before, after in pairs]
    along = [
        explains_along_field(before.baseline, after.baseline)
        for before, after in pairs
        if traits.field_source and before.problem.mode == "vector"
    ]
    enough = sum(shares) / max(len(shares), 1) >= effect.pooled.policy.trace
    return enough and 2 * sum(along) >= len(along)


def _is_contradicted(effect: PooledEffect, recordings: Sequence[PooledRecording]) -> bool:
    """Whether half of the recordings able to show the effect alone exclude it by a rule of their own diagnosis."""
    pooled, names = effect.pooled, {effect.name, *effect.alternatives}
    able = [recordings[i] for i in pooled.here if pooled.own_nats(i) > pooled.policy.coloured_nats]
    own = [{name for one in recording.own_effects for name in (one.name, *one.alternatives)} for recording in able]
    return bool(able) and 2 * sum(map(names.isdisjoint, own)) >= len(able)


def _with_alternatives(
    effect: PooledEffect,
    best: PooledCandidate,
    tried: Sequence[PooledCandidate],
    settings: Settings,
    recordings: Sequence[PooledRecording],
    *,
    coloured: bool,
) -> PooledEffect:
    """Choose the simplest of the candidates as good as the best, with all look-alikes as alternatives.

    Where coefficients differ, the recordings together do not tell the look-alikes: those that every recording lists
    whose own diagnosis names the effect are added.
    """
    closest, alike = look_alikes(best, tried, coloured=coloured)
    names = [*(one.name for one in (*closest, *alike)), *fit_equally_well(effect, settings)]
    simplest = select_simplest(closest, best.policy)
    simpler = effect if simplest is best else _assessed(simplest, recordings, coloured=coloured)
    last = effect if simpler.transfer is None else simpler
    if last.transfer is Transfer.NOT_TRANSFERRED:
        own = (one for recording in recordings for one in recording.own_effects)
        names += in_all([one.alternatives for one in own if one.name == last.name])
    return replace(last, alternatives=tuple(name for name in dict.fromkeys(names) if name != last.name))


def is_form_of(accepted: Sequence[PooledEffect], best: PooledEffect, first: Sequence[Posed]) -> bool:
    """Whether an effect is a form error of accepted effects: of one family, or far smaller.

    first : the recordings without any effect. A size far smaller than alone shows resemblance to accepted effects.
    """
    if any(in_same_family(best.pooled, effect.pooled) for effect in accepted):
        return True
    same = any(best.name == effect.name for effect in accepted)
    here = {i: CandidateInRecording.of(one.candidate, first[i], one.columns) for i, one in best.pooled.here.items()}
    alone = replace(best, pooled=replace(best.pooled, here=here))
    return is_form_by_size(best.strength, alone.strength, accepted[0].strength, best.pooled.policy, same=same)


def _named_by_one(
    recordings: Sequence[PooledRecording], settings: Settings, accepted: Sequence[PooledEffect]
) -> list[PooledEffect]:
    """Effects named by a single recording, tested next to the accepted effects of the pool."""
    known = {name for effect in accepted for name in (effect.name, *effect.alternatives)}
    own = {effect.name: effect.evidence.candidate for recording in recordings for effect in recording.own_effects}
    posed, alone = [recording.posed for recording in recordings], []
    for name, first in own.items():
        if name not in known:
            others = [setting for setting in settings[name] if setting != first]
            pooled = PooledCandidate.of([first, *others], posed)
            alone.append(replace(_assessed(pooled, recordings, coloured=True), transfer=None))
    return alone
