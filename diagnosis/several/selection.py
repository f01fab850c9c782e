"""Selection over several recordings: accept the effect of largest joint gain, with a noise model for each recording."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.decision.selection import tests_with_effects
from diagnosis.decision.white_choice import AcceptedEffect, in_same_family, is_form_by_size, select_simplest
from diagnosis.evidence.along_field import explains_along_field
from diagnosis.evidence.baseline import Baseline, added_share
from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.evidence.held_out import Evidence
from diagnosis.evidence.hypothesis import information_matrices
from diagnosis.evidence.noise_model import NoiseModel
from diagnosis.library.candidates import Candidate
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Transfer
from diagnosis.several.coefficients import CoefficientEstimate, cross_predicted_gains
from diagnosis.several.look_alikes import Settings, fit_equally_well, is_explained_by, look_alikes
from diagnosis.several.pooled_test import CandidateInRecording, PooledCandidate, columns_in, estimate, with_own_effects
from diagnosis.several.transfer import Presence, TransferFinding, assess_transfer
from diagnosis.workflow import Examination
from scenarios.arrays import Array
from sim.effects import EFFECTS

Progress = Callable[[str], object]


@dataclass(frozen=True, eq=False)
class PooledRecording:
    """A recording of the pool: its own diagnosis, its own events, and baselines without and with accepted effects."""

    examination: Examination
    events: tuple[AcceptedEffect, ...]
    start: Baseline
    baseline: Baseline

    @classmethod
    def of(cls, examination: Examination) -> PooledRecording:
        """The recording with its own events, not observable elsewhere."""
        start = examination.conclusion.selection.start
        events = tuple(event for event in examination.conclusion.accepted if event.evidence.candidate.one_run)
        baseline = start
        for event in events:
            baseline = baseline.with_columns(event.columns(start.problem))
        return cls(examination, events, start, baseline)

    @property
    def problem(self) -> LinearProblem:
        """The recording compared with the model."""
        return self.start.problem

    @property
    def own_effects(self) -> list[AcceptedEffect]:
        """Effects found by the recording's own diagnosis, without events."""
        return [effect for effect in self.examination.conclusion.accepted if effect not in self.events]

    @property
    def own_names(self) -> set[str]:
        """Names of the own effects and of their look-alikes."""
        return {name for effect in self.own_effects for name in (effect.name, *effect.alternatives)}

    def competing_columns(self, pooled: PooledCandidate) -> list[Array]:
        """Columns (N, q, k) of own effects of a different family that do not list the candidate as a look-alike."""
        others = (effect for effect in self.own_effects if pooled.name not in (effect.name, *effect.alternatives))
        return [effect.columns(self.problem) for effect in others if not in_same_family(effect.evidence, pooled)]

    def with_candidate(self, candidate: Candidate) -> PooledRecording:
        """The recording with a further effect in the baseline, where its causes are recorded."""
        columns = columns_in(candidate, self.problem)
        return self if columns is None else replace(self, baseline=self.baseline.with_columns(columns))


@dataclass(frozen=True)
class PooledEffect:
    """An effect accepted for the pool, and its look-alikes."""

    finding: TransferFinding
    alternatives: tuple[str, ...]

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.finding.pooled.name

    @property
    def strength(self) -> float:
        """Rms over the recordings with the effect, in units of the noise of each."""
        pairs = zip(self.finding.pooled.in_recordings, self.finding.presence, strict=True)
        sizes = [
            in_recording.strength
            for in_recording, presence in pairs
            if in_recording is not None and presence is Presence.PRESENT
        ]
        return float(
            np.sqrt(np.mean(np.square(sizes or [in_recording.strength for in_recording in self.finding.pooled.tested])))
        )

    def without_others(self, baselines: Sequence[ColouredBaseline]) -> PooledEffect:
        """The effect fitted without the other accepted effects."""
        pooled = self.finding.pooled
        in_recordings = tuple(
            in_recording
            and CandidateInRecording.of(
                in_recording.candidate, in_recording.problem, coloured_baseline, in_recording.columns
            )
            for in_recording, coloured_baseline in zip(pooled.in_recordings, baselines, strict=True)
        )
        return replace(self, finding=replace(self.finding, pooled=replace(pooled, in_recordings=in_recordings)))


def select_pooled(
    recordings: Sequence[PooledRecording], say: Progress
) -> tuple[list[PooledEffect], list[TransferFinding]]:
    """Select effects supported by several recordings; return them with the effects named by a single recording."""
    policy, settings, accepted = recordings[0].problem.policy, _settings(recordings), list[PooledEffect]()
    first = [ColouredBaseline.of(recording.problem, recording.baseline.accepted_columns) for recording in recordings]
    while len(accepted) < policy.most_effects and not (
        accepted and _residuals_are_clean(recordings, [effect.name for effect in accepted])
    ):
        say(f"all recordings together, round {len(accepted) + 1}")
        best = _best_candidate(recordings, settings, accepted)
        if best is None or _is_form_of_accepted(best, accepted, first, policy):
            break
        accepted.append(best)
        recordings = [recording.with_candidate(best.finding.pooled.candidate) for recording in recordings]
    return accepted, _named_by_one(recordings, settings, accepted)


def _settings(recordings: Sequence[PooledRecording]) -> Settings:
    """The settings of every effect accepted by a recording alone, or found best where none accepts the effect."""
    accepted, listed = Settings(), Settings()
    for recording in recordings:
        _gather(accepted, (effect.evidence for effect in recording.own_effects))
        _gather(listed, (effect.evidence for effect in recording.examination.conclusion.selection.results))
    return listed | accepted


def _gather(found: Settings, evidences: Iterable[Evidence]) -> None:
    for evidence in evidences:
        if not evidence.candidate.one_run and evidence.candidate not in found.setdefault(evidence.name, []):
            found[evidence.name].append(evidence.candidate)


def _residuals_are_clean(recordings: Sequence[PooledRecording], names: Sequence[str]) -> bool:
    return all(
        tests_with_effects(recording.baseline, [*names, *(event.name for event in recording.events)]).clean
        for recording in recordings
    )


def _best_candidate(
    recordings: Sequence[PooledRecording], settings: Settings, accepted: Sequence[PooledEffect]
) -> PooledEffect | None:
    """The most likely candidate supported by the recordings together."""
    baselines = [
        ColouredBaseline.of(recording.problem, recording.baseline.accepted_columns) for recording in recordings
    ]
    tried = _screened(recordings, baselines, settings, accepted)
    refused: list[PooledCandidate] = []
    for pooled in sorted(tried, key=lambda candidate: -candidate.gain):
        if any(is_explained_by(pooled.columns, better) for better in refused):
            continue  # explained by a better candidate, hence refused for the same reason
        with_candidate = [recording.with_candidate(pooled.candidate) for recording in recordings]
        coloured = not _residuals_are_clean(with_candidate, [*(effect.name for effect in accepted), pooled.name])
        finding = _finding(pooled, recordings, coloured=coloured)
        if _is_supported(finding, recordings, with_candidate, coloured=coloured):
            named = _with_alternatives(pooled, finding, tried, settings, recordings, coloured=coloured)
            if not _is_contradicted(named, recordings):
                return named
        # A recording with another cause may show the cause of all: then the rivals of this candidate stay.
        if finding.pooled.in_recordings == pooled.in_recordings:
            refused.append(pooled)
    return None


def _is_supported(
    finding: TransferFinding,
    recordings: Sequence[PooledRecording],
    with_candidate: Sequence[PooledRecording],
    *,
    coloured: bool,
) -> bool:
    """Whether the recordings support an effect beyond chance; in coloured noise, by enough of the gap as well."""
    if finding.transfer is None or finding.nats <= _largest_surrogate_gain(finding.pooled):
        return False
    return not coloured or (
        _explains_gap(finding, recordings, with_candidate) and _along_the_field(finding, recordings, with_candidate)
    )


def _is_contradicted(effect: PooledEffect, recordings: Sequence[PooledRecording]) -> bool:
    """Whether half of the recordings able to show the effect alone exclude it by a rule of their own diagnosis."""
    pooled, names = effect.finding.pooled, {effect.name, *effect.alternatives}
    able = [recording for i, recording in enumerate(recordings) if pooled.own_nats(i) > pooled.policy.coloured_nats]
    against = [recording for recording in able if not names & recording.own_names]
    return bool(able) and 2 * len(against) >= len(able)


def _finding(pooled: PooledCandidate, recordings: Sequence[PooledRecording], *, coloured: bool) -> TransferFinding:
    policy = recordings[0].problem.policy
    needed = policy.coloured_nats if coloured else policy.accepted_pooled(len(EFFECTS))
    pairs = zip(pooled.in_recordings, recordings, strict=True)
    in_recordings = tuple(
        in_recording and with_own_effects(in_recording, recording.competing_columns(pooled))
        for in_recording, recording in pairs
    )
    named = [
        i for i, recording in enumerate(recordings) if pooled.name in (effect.name for effect in recording.own_effects)
    ]
    return assess_transfer(replace(pooled, in_recordings=in_recordings), needed, policy, named)


def _screened(
    recordings: Sequence[PooledRecording],
    baselines: Sequence[ColouredBaseline],
    settings: Settings,
    accepted: Sequence[PooledEffect],
) -> list[PooledCandidate]:
    """Test the candidates of largest gain with the baselines' noise models, and all effects named by a recording."""
    problems = [recording.problem for recording in recordings]
    flat = [setting for listed in settings.values() for setting in listed]
    noise_models = [baseline.hypothesis.noise_model for baseline in baselines]
    likely = dict(zip(flat, _cross_predicted(flat, problems, baselines, noise_models), strict=True))
    best = {name: max(listed, key=lambda setting: likely[setting]) for name, listed in settings.items()}
    order = sorted(best, key=lambda name: -likely[best[name]])[: problems[0].policy.tried_coloured]
    own_names = {effect.name for recording in recordings for effect in recording.own_effects}
    names = dict.fromkeys([*order, *(own_names - {effect.name for effect in accepted})])
    return [pooled_candidate(best[name], settings[name], baselines, problems) for name in names]


def pooled_candidate(
    candidate: Candidate,
    settings: Sequence[Candidate],
    baselines: Sequence[ColouredBaseline],
    problems: Sequence[LinearProblem],
) -> PooledCandidate:
    """The candidate at its best setting: the setting of largest gain with the noise models left by the given one."""
    tried = max(setting.tried for setting in settings) * len(settings)
    pooled = PooledCandidate.of(candidate, baselines, problems, tried)
    if len(settings) == 1 or not pooled.tested:
        return pooled
    noise_models = [
        coloured_baseline.hypothesis.noise_model if in_recording is None else in_recording.hypothesis.noise_model
        for in_recording, coloured_baseline in zip(pooled.in_recordings, baselines, strict=True)
    ]
    likely = _cross_predicted(settings, problems, baselines, noise_models)
    best = max(settings, key=lambda setting: likely[settings.index(setting)])
    if best == candidate:
        return pooled
    return max(pooled, PooledCandidate.of(best, baselines, problems, tried), key=lambda tested: tested.gain)


def _cross_predicted(
    candidates: Sequence[Candidate],
    problems: Sequence[LinearProblem],
    baselines: Sequence[ColouredBaseline],
    noise_models: Sequence[NoiseModel],
) -> list[float]:
    """Nats explained in each recording by the other recordings' coefficients, summed, for given noise models."""
    estimates: dict[Candidate, list[CoefficientEstimate]] = {candidate: [] for candidate in candidates}
    for problem, coloured_baseline, noise_model in zip(problems, baselines, noise_models, strict=True):
        rows = {
            candidate: coloured_baseline.rows.bin(columns)
            for candidate in candidates
            if (columns := columns_in(candidate, problem)) is not None
        }
        products = information_matrices(
            coloured_baseline.rows, coloured_baseline.accepted_columns, list(rows.values()), noise_model
        )
        for candidate, product in zip(rows, products, strict=True):
            estimates[candidate].append(estimate(product))
    return [float(cross_predicted_gains(each).sum()) if each else -np.inf for each in estimates.values()]


def _largest_surrogate_gain(pooled: PooledCandidate) -> float:
    """Largest nats of common coefficients among surrogates, shifted alike in every recording."""
    turns = zip(*(in_recording.surrogates for in_recording in pooled.tested), strict=True)
    scaled = (
        [estimate(N, in_recording.inflation) for N, in_recording in zip(turn, pooled.tested, strict=True)]
        for turn in turns
    )
    return max(float(cross_predicted_gains(estimates).sum()) for estimates in scaled)


def _explains_gap(
    finding: TransferFinding, recordings: Sequence[PooledRecording], with_candidate: Sequence[PooledRecording]
) -> bool:
    """Whether a candidate explains a share of the gap where it is present."""
    pairs = zip(recordings, with_candidate, finding.presence, strict=True)
    shares = [
        added_share(before.start, before.baseline, after.baseline.squares)
        for before, after, presence in pairs
        if presence is Presence.PRESENT
    ]
    return float(np.mean(shares or [0.0])) >= recordings[0].problem.policy.trace


def _along_the_field(
    finding: TransferFinding, recordings: Sequence[PooledRecording], with_candidate: Sequence[PooledRecording]
) -> bool:
    """Whether a source gains along the field in at least half of the recordings."""
    gains_along = [
        explains_along_field(before.baseline, after.baseline)
        for before, after, presence in zip(recordings, with_candidate, finding.presence, strict=True)
        if presence is Presence.PRESENT
        and before.problem.mode == "vector"
        and finding.pooled.candidate.effect.traits.field_source
    ]
    return not gains_along or 2 * sum(gains_along) >= len(gains_along)


def _with_alternatives(
    best: PooledCandidate,
    finding: TransferFinding,
    tried: Sequence[PooledCandidate],
    settings: Settings,
    recordings: Sequence[PooledRecording],
    *,
    coloured: bool,
) -> PooledEffect:
    """Choose the simplest of the candidates as good as the best, with all look-alikes as alternatives."""
    problems = [recording.problem for recording in recordings]
    closest, alike = look_alikes(best, tried, problems[0].policy, coloured=coloured)
    simplest = select_simplest(closest, problems[0].policy)
    names = dict.fromkeys(
        [*(candidate.name for candidate in (*closest, *alike)), *fit_equally_well(finding, settings, problems)]
    )
    simplest_finding = finding if simplest is best else _finding(simplest, recordings, coloured=coloured)
    last = finding if simplest_finding.transfer is None else simplest_finding
    if last.transfer is Transfer.NOT_TRANSFERRED:
        names |= dict.fromkeys(_common_alternatives(last.pooled.name, recordings))
    return PooledEffect(last, tuple(name for name in names if name != last.pooled.name))


def _common_alternatives(name: str, recordings: Sequence[PooledRecording]) -> list[str]:
    """Look-alikes listed by every recording whose own diagnosis names the effect.

    Where coefficients differ, the remaining recordings carry no information on look-alikes.
    """
    alternatives = [
        effect.alternatives for recording in recordings for effect in recording.own_effects if effect.name == name
    ]
    return (
        [other for other in alternatives[0] if all(other in listed for listed in alternatives)] if alternatives else []
    )


def _is_form_of_accepted(
    best: PooledEffect, accepted: Sequence[PooledEffect], first: Sequence[ColouredBaseline], policy: Policy
) -> bool:
    """Whether an effect is a form error of accepted effects: of one family, or far smaller.

    first : the baselines without any effect. A size far smaller than alone shows resemblance to accepted effects.
    """
    if not accepted:
        return False
    if any(in_same_family(best.finding.pooled, effect.finding.pooled) for effect in accepted):
        return True
    same = any(best.name == effect.name for effect in accepted)
    alone = best.without_others(first).strength
    return is_form_by_size(best.strength, alone, accepted[0].strength, policy, same=same)


def _named_by_one(
    recordings: Sequence[PooledRecording], settings: Settings, accepted: Sequence[PooledEffect]
) -> list[TransferFinding]:
    """Effects named by a single recording, tested next to the accepted effects of the pool."""
    known = {name for effect in accepted for name in (effect.name, *effect.alternatives)}
    alone = {
        effect.name: effect.evidence.candidate
        for recording in recordings
        for effect in recording.own_effects
        if effect.name not in known
    }
    baselines = (
        [ColouredBaseline.of(effect.problem, effect.baseline.accepted_columns) for effect in recordings]
        if alone
        else []
    )
    problems = [effect.problem for effect in recordings]
    joints = [pooled_candidate(candidate, settings[name], baselines, problems) for name, candidate in alone.items()]
    return [replace(_finding(pooled, recordings, coloured=True), transfer=None) for pooled in joints]
