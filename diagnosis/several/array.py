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
    compared = _compared_effects(examinations, each)
    return with_sentences(_diagnosis(tuple(names), each, compared))


def _diagnosis(
    names: tuple[str, ...], each: tuple[Diagnosis, ...], compared: Sequence[CommonEffect]
) -> PooledDiagnosis:
    """The diagnoses of the sensors with compared effects, without sentences."""
    first = worst(each)
    return PooledDiagnosis(
        names=names,
        each=each,
        verdict=each[first].verdict,
        common=tuple(effect for effect in compared if effect.several),
        single=tuple(effect for effect in compared if not effect.several),
        gaps=tuple(own.gap for own in each),
        where=mean_shares([own.where for own in each], each[0].problem.policy),
        unexplained=tuple(f"{name}: {why}" for name, own in zip(names, each, strict=True) for why in own.unexplained),
        model=each[first].model,
        before_nT=tuple(own.before_nT for own in each),
        after_nT=tuple(own.after_nT for own in each),
        scope=SENSORS,
        first=first,
    )


def _compared_effects(examinations: Sequence[Examination], each: Sequence[Diagnosis]) -> list[CommonEffect]:
    """Every named effect fitted to all sensors, next to all other effects."""
    named = {cause.name for diagnosis in each for cause in diagnosis.named if cause.kind is EvidenceKind.HELD_OUT}
    accepted = [own for examination in examinations for own in examination.conclusion.accepted if own.name in named]
    problems = [examination.problem for examination in examinations]
    return [_compared_effect(name, accepted, problems) for name in dict.fromkeys(own.name for own in accepted)]


def _compared_effect(name: str, accepted: Sequence[AcceptedEffect], problems: Sequence[LinearProblem]) -> CommonEffect:
    """An effect at the setting of one of the sensors, the strongest first, with that sensor's look-alikes."""
    strongest, *others = sorted((own for own in accepted if own.name == name), key=lambda own: -own.evidence.nats)
    beside = dict.fromkeys(own.evidence.candidate for own in accepted if own.name != name)
    settings = dict.fromkeys(own.evidence.candidate for own in (strongest, *others))
    pooled = PooledCandidate.of(list(settings), baselines_with(list(beside), problems), problems)
    effect = replace(compare_sensors(pooled, problems[0].policy), alternatives=strongest.alternatives)
    return common_effect(effect, problems, strongest.evidence.strength)
