"""The sensors of an array: diagnosed one by one, then named effects are compared between sensors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from diagnosis.decision.white_choice import AcceptedEffect
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Diagnosis, EvidenceKind
from diagnosis.several.common_effects import CommonEffect, common_effect
from diagnosis.several.pooled_test import PooledCandidate, baselines_with
from diagnosis.several.result import SENSORS, PooledDiagnosis, worst
from diagnosis.several.sentence import with_sentences
from diagnosis.several.transfer import compare_sensors
from diagnosis.several.workflow import examine_each, mean_shares
from diagnosis.workflow import Examination, diagnosis_of
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
    sensors = [(*sensor, without) for sensor in zip(names, problems, models, strict=True)]
    examinations = examine_each(sensors, say)
    each = tuple(diagnosis_of(examination) for examination in examinations)
    say("comparison of the sensors")
    compared, first = _compared_effects(examinations, each), worst(each)
    left = ((name, why) for name, diagnosis in zip(names, each, strict=True) for why in diagnosis.unexplained)
    diagnosis = PooledDiagnosis(
        names=tuple(names),
        each=each,
        verdict=each[first].verdict,
        common=tuple(effect for effect in compared if effect.several),
        single=tuple(effect for effect in compared if not effect.several),
        gaps=tuple(diagnosis.gap for diagnosis in each),
        where=mean_shares([diagnosis.where for diagnosis in each], each[0].problem.policy),
        unexplained=tuple(f"{name}: {why}" for name, why in left),
        model=each[first].model,
        before_nT=tuple(diagnosis.before_nT for diagnosis in each),
        after_nT=tuple(diagnosis.after_nT for diagnosis in each),
        scope=SENSORS,
        first=first,
    )
    return with_sentences(diagnosis)


def _compared_effects(examinations: Sequence[Examination], each: Sequence[Diagnosis]) -> list[CommonEffect]:
    """Every named effect fitted to all sensors, next to all other effects, at the setting of one of the sensors."""
    named = {cause.name for diagnosis in each for cause in diagnosis.named if cause.kind is EvidenceKind.HELD_OUT}
    by_name: dict[str, list[AcceptedEffect]] = {}
    for own in (own for examination in examinations for own in examination.conclusion.accepted):
        if own.name in named:
            by_name.setdefault(own.name, []).append(own)
    problems, compared = [examination.problem for examination in examinations], []
    for name, accepted in by_name.items():
        strongest, *others = sorted(accepted, key=lambda own: -own.evidence.nats)
        beside = [own.evidence.candidate for other in by_name if other != name for own in by_name[other]]
        settings = list(dict.fromkeys(own.evidence.candidate for own in (strongest, *others)))
        pooled = PooledCandidate.of(settings, baselines_with(list(dict.fromkeys(beside)), problems), problems)
        effect = replace(compare_sensors(pooled, problems[0].policy), alternatives=strongest.alternatives)
        compared.append(common_effect(effect, problems, strongest.evidence.strength))
    return compared
