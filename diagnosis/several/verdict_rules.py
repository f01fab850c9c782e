"""The verdict on several recordings: conclusions with the common effects as one case, then doubts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diagnosis.decision.conclusion import Conclusion, conclude
from diagnosis.decision.selection import residual_tests
from diagnosis.decision.verdict_rules import VerdictInput, doubts_of, verdict_of
from diagnosis.decision.white_choice import AcceptedEffect
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import judge_settings
from diagnosis.evidence.localise import localise
from diagnosis.evidence.rising_spectrum import RisingSpectrum
from diagnosis.repair.named_effects import named_noise
from diagnosis.result import EvidenceKind, GapSize, NamedEffect, Transfer
from diagnosis.several.coefficients import predicted_by_others
from diagnosis.several.common_effects import (
    CommonEffect,
    common_effect,
    common_iron_changes,
    common_value_effects,
    with_common_rivals,
)
from diagnosis.several.result import joint_gap
from diagnosis.several.selection import PooledRecording
from diagnosis.several.transfer import PooledEffect
from diagnosis.verdict import Verdict
from scenarios.arrays import Array


@dataclass(frozen=True)
class PooledVerdict:
    """Verdict and common effects of a pool after all doubts, with conclusion, case and doubts of each recording.

    before : residuals (n, q) of the base, in units of the noise; the residuals of the cases are those of the effects.
    """

    verdict: Verdict
    common: tuple[CommonEffect, ...]
    conclusions: tuple[Conclusion, ...]
    cases: tuple[VerdictInput, ...]
    doubts: tuple[tuple[str, ...], ...]
    before: tuple[Array, ...]

    @classmethod
    def of(cls, recordings: Sequence[PooledRecording], effects: Sequence[PooledEffect]) -> PooledVerdict:
        """Reach a verdict on all recordings as one case; drop effects doubted by half of the recordings."""
        conclusions = tuple(_conclusion(recording, i, effects) for i, recording in enumerate(recordings))
        common = _common_effects(recordings, effects, conclusions)
        named = tuple(effect.named for effect in common)
        before = tuple(recording.start.residual() for recording in recordings)
        after = [_residual(recording, i, effects) for i, recording in enumerate(recordings)]
        cases = tuple(map(_case, recordings, [named] * len(recordings), conclusions, before, after))
        rise = next((case.rise for case in cases if case.rise), None)
        gap = joint_gap([case.gap for case in cases])
        joint = replace(cases[0], clean=_is_clean(common, conclusions), gap=gap, where=(), rise=rise)
        verdict = verdict_of(joint)
        doubts = tuple(doubts_of(case, verdict) for case in cases)
        pooled = cls(verdict, common, conclusions, cases, doubts, before)
        return pooled.without_names() if pooled.is_doubted else pooled

    @property
    def is_doubted(self) -> bool:
        """Whether the effects explain too little, or half of the recordings raise doubts."""
        return self.verdict is Verdict.UNKNOWN or 2 * sum(map(bool, self.doubts)) >= len(self.doubts)

    def without_names(self) -> PooledVerdict:
        """The verdict without named effects: nothing is explained."""
        direct = tuple(effect for effect in self.common if effect.named.kind is EvidenceKind.DIRECT)
        cases = tuple(
            replace(case, gap=case.gap.without_effects(), residual=before)
            for case, before in zip(self.cases, self.before, strict=True)
        )
        return replace(self, verdict=Verdict.UNKNOWN, common=direct, cases=cases)

    def unexplained(self, names: Sequence[str]) -> tuple[str, ...]:
        """Structure left in each recording, and doubts about the effects."""
        rows = zip(names, self.conclusions, self.cases, self.doubts, strict=True)
        return tuple(
            f"{name}: {why}"
            for name, conclusion, case, doubts in rows
            for why in (*conclusion.after.why, *([case.rise.words] if case.rise else []), *doubts)
        )


def _conclusion(recording: PooledRecording, i: int, effects: Sequence[PooledEffect]) -> Conclusion:
    """Conclusion of one recording with the pool's effects.

    Slow noise of unknown nature is none: a disturbance following the motion is alike in every recording.
    """
    accepted, baseline = recording.events, recording.baseline
    for effect in effects:
        evidence = judge_settings(baseline, [effect.pooled.candidate]) if i in effect.possible else None
        if evidence is not None:
            accepted.append(AcceptedEffect(evidence, effect.alternatives))
            baseline = baseline.with_columns(effect.pooled.candidate.columns(recording.problem))
    selection = recording.examination.conclusion.selection
    after = residual_tests(baseline, [effect.name for effect in accepted]) if accepted else selection.before
    conclusion = conclude(replace(selection, accepted=tuple(accepted), end=baseline, after=after))
    return conclusion if conclusion.noise is None or conclusion.noise.identified else replace(conclusion, noise=None)


def _residual(recording: PooledRecording, i: int, effects: Sequence[PooledEffect]) -> Array:
    """Residual (n, q) of one recording, with coefficients predicted by the other recordings.

    An effect that does not transfer is fitted together with the recording's iron.
    """
    target, columns = recording.problem.target, list(recording.baseline.accepted_columns)
    for effect in effects:
        if i in effect.possible:
            own = effect.pooled.candidate.columns(recording.problem)
            if effect.transfer is Transfer.NOT_TRANSFERRED:
                columns.append(own)
            else:
                target = target - own @ predicted_by_others(effect.possible)[i]
    return Baseline.of(replace(recording.problem, target=target), columns).residual()


def _case(
    recording: PooledRecording, named: tuple[NamedEffect, ...], conclusion: Conclusion, before: Array, after: Array
) -> VerdictInput:
    """The case of one recording with the pool's effects."""
    problem, use = recording.problem, recording.problem.usable > 0
    gap = GapSize.of(before[use], after[use], problem.sigma_nT, problem.policy)
    where, rise = localise(problem, before), RisingSpectrum.of(problem, before, after)
    return VerdictInput(problem, named, conclusion.clean, gap, where, after, rise)


def _common_effects(
    recordings: Sequence[PooledRecording], effects: Sequence[PooledEffect], conclusions: Sequence[Conclusion]
) -> tuple[CommonEffect, ...]:
    """Effects, changes of the iron, noise and direct evidence supported by more than one recording."""
    problems = [recording.problem for recording in recordings]
    strongest = sorted(((effect.strength, effect) for effect in effects), key=lambda pair: -pair[0])
    fitted = [with_common_rivals(common_effect(effect, problems, size), problems) for size, effect in strongest]
    iron = common_iron_changes([conclusion.iron for conclusion in conclusions], problems)
    others = [effect.named for effect in (*fitted, *iron)]
    values = [
        [*(NamedEffect(d.effect, (), EvidenceKind.DIRECT, None, 0.0) for d in direct), *named_noise(conclusion, others)]
        for direct, conclusion in zip((one.examination.direct for one in recordings), conclusions, strict=True)
    ]
    of_values = common_value_effects(values, problems[0].policy)
    return (*fitted, *iron, *(effect for effect in of_values if _is_sensor_noise(effect)))


def _is_clean(common: Sequence[CommonEffect], conclusions: Sequence[Conclusion]) -> bool:
    """Whether every recording is clean; without common effects, slow noise does not count as clean."""
    return all(conclusion.clean if common else conclusion.after.clean for conclusion in conclusions)


def _is_sensor_noise(effect: CommonEffect) -> bool:
    """Whether slow noise has one size in all recordings; noise of varying size comes from outside the sensor."""
    slow = effect.named.kind is EvidenceKind.SPECTRUM and effect.named.effect.traits.spectrum is not None
    return not slow or effect.transfer is Transfer.TRANSFERRED
