"""The verdict on several recordings: conclusions with the common effects as one case, then doubts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.decision.conclusion import Conclusion, conclude
from diagnosis.decision.selection import tests_with_effects
from diagnosis.decision.verdict_rules import VerdictInput, doubts_of, verdict_of
from diagnosis.decision.white_choice import AcceptedEffect
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import judge_settings
from diagnosis.evidence.localise import localise
from diagnosis.evidence.rising_spectrum import RisingSpectrum
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.named_effects import named_noise
from diagnosis.result import EvidenceKind, GapSize, NamedEffect, Transfer
from diagnosis.several.coefficients import predicted_by_others
from diagnosis.several.common_effects import (
    CommonEffect,
    common_fitted_effect,
    common_iron_changes,
    common_value_effects,
)
from diagnosis.several.selection import PooledEffect, PooledRecording
from diagnosis.several.transfer import Presence, TransferFinding
from diagnosis.verdict import Verdict
from scenarios.arrays import Array
from validation.signals.amplitude import rms


@dataclass(frozen=True)
class Pool:
    """The recordings of one instrument, and the effects accepted for all."""

    recordings: Sequence[PooledRecording]
    effects: Sequence[PooledEffect]

    @property
    def problems(self) -> list[LinearProblem]:
        """The recordings compared with the model."""
        return [recording.problem for recording in self.recordings]

    @property
    def before(self) -> tuple[Array, ...]:
        """Residual (n, q) of the base in each recording, in units of the noise."""
        return tuple(recording.examination.conclusion.selection.start.residual() for recording in self.recordings)

    def conclusion(self, i: int) -> Conclusion:
        """Conclusion of one recording with the pool's effects."""
        recording, accepted = self.recordings[i], list(self.recordings[i].events)
        baseline = recording.baseline
        for effect in self.effects:
            pooled = effect.finding.pooled
            if pooled.in_recordings[i] is None or effect.finding.presence[i] is Presence.ABSENT:
                continue
            evidence = judge_settings(baseline, [pooled.candidate])
            if evidence is not None:
                accepted.append(AcceptedEffect(evidence, effect.alternatives))
                baseline = baseline.with_columns(pooled.candidate.columns(recording.problem))
        selection = recording.examination.conclusion.selection
        after = tests_with_effects(baseline, [effect.name for effect in accepted]) if accepted else selection.before
        return conclude(replace(selection, accepted=tuple(accepted), end=baseline, after=after))

    def residual(self, i: int) -> Array:
        """Residual (n, q) of one recording, with coefficients predicted by the other recordings.

        Where coefficients differ between recordings, the recording's own are fitted together with its iron.
        """
        recording = self.recordings[i]
        target, start = recording.problem.target, recording.examination.conclusion.selection.start
        columns_of_effects = [
            *start.accepted_columns,
            *(event.columns(recording.problem) for event in recording.events),
        ]
        for effect in self.effects:
            finding = effect.finding
            if finding.pooled.in_recordings[i] is None or finding.presence[i] is Presence.ABSENT:
                continue
            effect_columns = finding.pooled.candidate.columns(recording.problem)
            if finding.transfer is Transfer.NOT_TRANSFERRED:
                columns_of_effects.append(effect_columns)
            else:
                target = target - effect_columns @ _predicted_coefficients(finding, i)
        return Baseline.of(replace(recording.problem, target=target), columns_of_effects).residual()


def _predicted_coefficients(finding: TransferFinding, i: int) -> Array:
    """Coefficients (k,) estimated from the other recordings."""
    present = [
        (j, estimate)
        for j, (estimate, presence) in enumerate(zip(finding.pooled.estimates, finding.presence, strict=True))
        if estimate is not None and presence is not Presence.ABSENT
    ]
    place = [j for j, _ in present].index(i)
    return np.asarray(predicted_by_others([estimate for _, estimate in present])[place])


@dataclass(frozen=True)
class PooledVerdict:
    """Verdict and effects of a pool after all doubts, with the residuals (n, q) in units of the noise."""

    verdict: Verdict
    common: tuple[CommonEffect, ...]
    conclusions: tuple[Conclusion, ...]
    cases: tuple[VerdictInput, ...]
    doubts: tuple[tuple[str, ...], ...]
    gap: GapSize
    gaps: tuple[GapSize, ...]
    before: tuple[Array, ...]
    after: tuple[Array, ...]

    @classmethod
    def of(cls, pool: Pool) -> PooledVerdict:
        """Reach a verdict on all recordings as one case; drop effects doubted by half of the recordings."""
        conclusions = tuple(_without_open_noise(pool.conclusion(i)) for i in range(len(pool.recordings)))
        common = _common_effects(pool, conclusions)
        named = [effect.named for effect in common]
        cases = tuple(_case(pool, i, named, conclusion) for i, conclusion in enumerate(conclusions))
        gaps = tuple(case.gap for case in cases)
        rise = next(filter(None, (case.rise for case in cases)), None)
        joint = replace(cases[0], clean=_is_clean(common, conclusions), gap=joint_gap(gaps), where=(), rise=rise)
        verdict = verdict_of(joint)
        doubts = tuple((*doubts_of(case, verdict), *_small_share_doubt(case)) for case in cases)
        after = tuple(case.residual for case in cases)
        pooled = cls(verdict, common, conclusions, cases, doubts, joint.gap, gaps, pool.before, after)
        return pooled.without_names() if pooled.is_doubted else pooled

    @property
    def is_doubted(self) -> bool:
        """Whether the effects explain too little, or half of the recordings raise doubts."""
        return self.verdict is Verdict.UNKNOWN or 2 * sum(map(bool, self.doubts)) >= len(self.doubts)

    def without_names(self) -> PooledVerdict:
        """The verdict without named effects: nothing is explained."""
        direct = tuple(effect for effect in self.common if effect.named.kind is EvidenceKind.DIRECT)
        gaps = tuple(gap.without_effects() for gap in self.gaps)
        return replace(
            self, verdict=Verdict.UNKNOWN, common=direct, gap=self.gap.without_effects(), gaps=gaps, after=self.before
        )

    def unexplained(self, names: Sequence[str]) -> tuple[str, ...]:
        """Structure left in each recording, and doubts about the effects."""
        rows = zip(names, self.conclusions, self.cases, self.doubts, strict=True)
        return tuple(
            f"{name}: {why}"
            for name, conclusion, case, doubts in rows
            for why in (*conclusion.after.why, *([case.rise.words] if case.rise else []), *doubts)
        )


def _small_share_doubt(case: VerdictInput) -> tuple[str, ...]:
    """Doubt where a coloured residual remains and the effects explain less than the least share."""
    explained = case.gap.explained
    if case.clean or explained is None or explained >= case.problem.policy.fair_share or not case.held_out_effects:
        return ()
    return (f"coefficients of the other recordings explain {100 * explained:.0f} % of its gap",)


def _case(pool: Pool, i: int, named: Sequence[NamedEffect], conclusion: Conclusion) -> VerdictInput:
    """The case of one recording with the pool's effects."""
    recording, after = pool.recordings[i], pool.residual(i)
    before = pool.before[i]
    use = recording.problem.usable > 0
    gap = GapSize.of(before[use], after[use], recording.problem.sigma_nT, recording.problem.policy)
    where, rise = localise(recording.problem, before), RisingSpectrum.of(recording.problem, before, after)
    return VerdictInput(recording.problem, tuple(named), conclusion.clean, gap, where, after, rise)


def _common_effects(pool: Pool, conclusions: Sequence[Conclusion]) -> tuple[CommonEffect, ...]:
    """Effects, changes of the iron, noise and direct evidence supported by more than one recording."""
    fitted = sorted(pool.effects, key=lambda effect: -effect.strength)
    effects = [common_fitted_effect(effect, pool.problems) for effect in fitted]
    iron = common_iron_changes([effect.iron for effect in conclusions], pool.problems)
    direct = [
        [NamedEffect(d.effect, (), EvidenceKind.DIRECT, None, 0.0) for d in effect.examination.direct]
        for effect in pool.recordings
    ]
    noise = [named_noise(conclusion, [effect.named for effect in (*effects, *iron)]) for conclusion in conclusions]
    values = common_value_effects([[*d, *n] for d, n in zip(direct, noise, strict=True)], pool.problems[0].policy)
    return (*effects, *iron, *(effect for effect in values if _is_sensor_noise(effect)))


def _is_clean(common: Sequence[CommonEffect], conclusions: Sequence[Conclusion]) -> bool:
    """Whether every recording is clean; without common effects, slow noise does not count as clean."""
    return all(conclusion.clean if common else conclusion.after.clean for conclusion in conclusions)


def _is_sensor_noise(effect: CommonEffect) -> bool:
    """Whether slow noise has one size in all recordings; noise of varying size comes from outside the sensor."""
    slow = effect.named.kind is EvidenceKind.SPECTRUM and effect.named.effect.traits.spectrum is not None
    return not slow or effect.transfer is Transfer.TRANSFERRED


def _without_open_noise(conclusion: Conclusion) -> Conclusion:
    """Drop slow noise of unknown nature: a disturbance following the motion is alike in every recording."""
    unidentified = conclusion.noise is not None and not conclusion.noise.identified
    return replace(conclusion, noise=None) if unidentified else conclusion


def joint_gap(gaps: Sequence[GapSize]) -> GapSize:
    """Size of several gaps with equal weight; the explained share counts recordings with a gap only."""
    gaps_explained = [gap for gap in gaps if gap.explained is not None]
    excess = sum(gap.before_sigma**2 - 1 for gap in gaps_explained)
    explained = (
        min(1.0, sum(gap.before_sigma**2 - gap.after_sigma**2 for gap in gaps_explained) / excess)
        if gaps_explained
        else None
    )
    before_nT, before, after_nT, after = (
        rms(np.array([getattr(gap, name) for gap in gaps]))
        for name in ("before_nT", "before_sigma", "after_nT", "after_sigma")
    )
    return GapSize(before_nT, before, after_nT, after, explained)
