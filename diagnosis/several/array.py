"""The sensors of an array: diagnosed one by one, then named effects are compared between sensors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from diagnosis.decision.white_choice import AcceptedEffect
from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Diagnosis, EvidenceKind
from diagnosis.several.common_effects import CommonEffect, common_effect
from diagnosis.several.pooled_test import columns_in
from diagnosis.several.result import PooledDiagnosis, worst
from diagnosis.several.scope import SENSORS
from diagnosis.several.selection import pooled_candidate
from diagnosis.several.sentence import array_advice, headline_sentence
from diagnosis.several.transfer import compare_sensors
from diagnosis.several.verdict_rules import joint_gap
from diagnosis.several.workflow import mean_shares
from diagnosis.workflow import Examination, diagnosis_of, examine
from sim.scenario import Model

Progress = Callable[[str], object]


def diagnose_sensors(
    names: Sequence[str],
    problems: Sequence[LinearProblem],
    models: Sequence[Model],
    *,
    without: frozenset[str] = frozenset(),
    say: Progress = lambda step: None,
) -> PooledDiagnosis:
    """Diagnose n sensors of one array against their models, and compare the named effects.

    Each sensor has its own diagnosis; the verdict is the worst sensor's. Evidence is not summed over sensors, which
    share the slow errors of the run. Every named effect is fitted to all sensors: a common coefficient shows a distant
    or shared source, differing coefficients a source nearby.
    """
    examinations = []
    for name, problem, model in zip(names, problems, models, strict=True):
        examinations.append(examine(problem, model, without, lambda step, name=name: say(f"{name}: {step}")))  # type: ignore[misc]
    each = tuple(diagnosis_of(examination) for examination in examinations)
    say("comparison of the sensors")
    diagnosis = _diagnosis(tuple(names), each, _compared_effects(examinations, each))
    return replace(diagnosis, sentence=headline_sentence(diagnosis), advice=array_advice(diagnosis))


def _diagnosis(
    names: tuple[str, ...], each: tuple[Diagnosis, ...], compared: Sequence[CommonEffect]
) -> PooledDiagnosis:
    """The diagnoses of the sensors with compared effects, without sentences."""
    first = worst(each)
    residual_findings = (
        f"{name}: {why}" for name, diagnosis in zip(names, each, strict=True) for why in diagnosis.unexplained
    )
    return PooledDiagnosis(
        names=names,
        each=each,
        verdict=each[first].verdict,
        sentence="",
        common=tuple(effect for effect in compared if effect.several),
        single=tuple(effect for effect in compared if not effect.several),
        gap=joint_gap([diagnosis.gap for diagnosis in each]),
        gaps=tuple(diagnosis.gap for diagnosis in each),
        where=mean_shares([diagnosis.where for diagnosis in each], each[0].problem.policy),
        unexplained=tuple(residual_findings),
        advice=(),
        model=each[first].model,
        before_nT=tuple(diagnosis.before_nT for diagnosis in each),
        after_nT=tuple(diagnosis.after_nT for diagnosis in each),
        scope=SENSORS,
        first=first,
    )


def _compared_effects(examinations: Sequence[Examination], each: Sequence[Diagnosis]) -> list[CommonEffect]:
    """Every named effect fitted to all sensors, next to all other effects."""
    named = {cause.name for diagnosis in each for cause in diagnosis.named if cause.kind is EvidenceKind.HELD_OUT}
    accepted_by_name: dict[str, list[AcceptedEffect]] = {}
    for examination in examinations:
        for accepted in examination.conclusion.accepted:
            if accepted.name in named:
                accepted_by_name.setdefault(accepted.name, []).append(accepted)
    problems = [examination.problem for examination in examinations]
    return [_compared_effect(name, accepted_by_name, problems) for name in accepted_by_name]


def _compared_effect(
    name: str, accepted_by_name: dict[str, list[AcceptedEffect]], problems: Sequence[LinearProblem]
) -> CommonEffect:
    strongest = max(accepted_by_name[name], key=lambda effect: effect.evidence.nats)
    settings = list(dict.fromkeys(effect.evidence.candidate for effect in accepted_by_name[name]))
    other_candidates = {
        effect.evidence.candidate
        for other_name in accepted_by_name
        if other_name != name
        for effect in accepted_by_name[other_name]
    }
    baselines = []
    for problem in problems:
        columns = [
            columns_here for other in other_candidates if (columns_here := columns_in(other, problem)) is not None
        ]
        baselines.append(ColouredBaseline.of(problem, columns))
    pooled = pooled_candidate(strongest.evidence.candidate, settings, baselines, problems)
    return common_effect(
        compare_sensors(pooled, problems[0].policy), strongest.alternatives, problems, strongest.evidence.strength
    )
