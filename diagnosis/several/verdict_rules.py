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
from diagnosis.evidence.residual_tests import ResidualTests
from diagnosis.evidence.rising_spectrum import RisingSpectrum
from diagnosis.repair.named_effects import named_values
from diagnosis.result import OF_VALUES, Diagnosis, EvidenceKind, GapSize, Transfer
from diagnosis.several.coefficients import predicted_by_others
from diagnosis.several.common_effects import (
    CommonEffect,
    common_effect,
    common_iron_changes,
    common_value_effects,
    with_common_rivals,
)
from diagnosis.several.result import RecordingGap, joint_gap
from diagnosis.several.selection import PooledRecording
from diagnosis.several.transfer import PooledEffect
from diagnosis.verdict import Verdict
from scenarios.arrays import Array


@dataclass(frozen=True)
class PooledVerdict:
    """Verdict on all recordings together, the common effects, and the gap of each recording."""

    verdict: Verdict
    common: tuple[CommonEffect, ...]
    gaps: tuple[RecordingGap, ...]

    @classmethod
    def of(cls, recordings: Sequence[PooledRecording], effects: Sequence[PooledEffect]) -> PooledVerdict:
        """Reach a verdict on recordings with the pool's effects, changes of the iron, noise and direct evidence."""
        conclusions = [_conclusion(recording, i, effects) for i, recording in enumerate(recordings)]
        common, cases = _common_effects(recordings, effects, conclusions), []
        before = [recording.start.residual() for recording in recordings]
        for i, (recording, conclusion) in enumerate(zip(recordings, conclusions, strict=True)):
            problem, use, after = recording.problem, recording.problem.usable > 0, _residual(recording, i, effects)
            gap = GapSize.of(before[i][use], after[use], problem.sigma_nT, problem.policy)
            where, rise = localise(problem, before[i]), RisingSpectrum.of(problem, before[i], after)
            named = tuple(effect.named for effect in common)
            cases.append(VerdictInput(problem, named, conclusion.clean, gap, where, after, rise))
        return cls.judge(common, cases, before, [conclusion.after for conclusion in conclusions])

    @classmethod
    def judge(
        cls,
        common: tuple[CommonEffect, ...],
        cases: Sequence[VerdictInput],
        before: Sequence[Array],
        after: Sequence[ResidualTests],
    ) -> PooledVerdict:
        """Reach a verdict on all cases as one; withdraw the effects where they explain too little or half doubt them.

        before : residuals (n, q) without effects, in units of the noise; after : tests of the residuals with effects.
        Without common effects, slow noise does not count as clean.
        """
        clean = all(case.clean if common else tests.clean for case, tests in zip(cases, after, strict=True))
        rise = next((case.rise for case in cases if case.rise), None)
        gap = joint_gap([case.gap for case in cases])
        verdict = verdict_of(replace(cases[0], clean=clean, gap=gap, where=(), rise=rise))
        doubts = [doubts_of(case, verdict) for case in cases]
        gaps = tuple(map(RecordingGap.of, cases, before, after, doubts))
        if verdict is Verdict.UNKNOWN or 2 * sum(map(bool, doubts)) >= len(doubts):
            direct = tuple(effect for effect in common if effect.named.kind is EvidenceKind.DIRECT)
            return cls(Verdict.UNKNOWN, direct, tuple(gap.without_effects() for gap in gaps))
        return cls(verdict, common, gaps)

    def says_less_than(self, each: Sequence[Diagnosis]) -> bool:
        """Whether the recordings alone say more than all together.

        Nothing is common to all, and every recording alone has its answer or all together none; or only noise and steps
        of the values are common, and a recording has an effect or iron of its own.
        """
        if self.verdict is Verdict.NONE:
            return any(one.verdict is not Verdict.NONE for one in each)
        if self.verdict.explained:
            own_cause = any(cause.kind not in OF_VALUES for one in each for cause in one.named)
            return own_cause and all(effect.named.kind in OF_VALUES for effect in self.common)
        return self.verdict is Verdict.UNKNOWN and all(one.verdict.explained for one in each)


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


def _common_effects(
    recordings: Sequence[PooledRecording], effects: Sequence[PooledEffect], conclusions: Sequence[Conclusion]
) -> tuple[CommonEffect, ...]:
    """Effects, changes of the iron, noise and direct evidence supported by more than one recording."""
    problems = [recording.problem for recording in recordings]
    strongest = sorted(((effect.strength, effect) for effect in effects), key=lambda pair: -pair[0])
    fitted = [with_common_rivals(common_effect(effect, problems, size), problems) for size, effect in strongest]
    common = (*fitted, *common_iron_changes([conclusion.iron for conclusion in conclusions], problems))
    others = [effect.named for effect in common]
    values = [
        named_values(conclusion, recording.examination.direct, others)
        for recording, conclusion in zip(recordings, conclusions, strict=True)
    ]
    return (*common, *filter(_is_of_the_sensor, common_value_effects(values, problems[0].policy)))


def _is_of_the_sensor(effect: CommonEffect) -> bool:
    """Whether slow noise has one size in all recordings; noise of varying size comes from outside the sensor."""
    slow = effect.named.kind is EvidenceKind.SPECTRUM and effect.named.effect.traits.spectrum is not None
    return not slow or effect.transfer is Transfer.TRANSFERRED
