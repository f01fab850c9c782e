"""The diagnosis of several recordings, or of the sensors of an array: each by itself, then all together."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from calib.numerics.threads import one_thread
from diagnosis.decision.white_choice import AcceptedEffect
from diagnosis.evidence.localise import ChannelShare
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.new_model import patch_model
from diagnosis.result import OF_VALUES, Diagnosis, EvidenceKind
from diagnosis.several.common_effects import CommonEffect, common_effect
from diagnosis.several.pooled_test import PooledCandidate, baselines_with
from diagnosis.several.result import SENSORS, PooledDiagnosis, worst
from diagnosis.several.selection import PooledRecording, select_pooled
from diagnosis.several.sentence import with_sentences
from diagnosis.several.transfer import compare_sensors
from diagnosis.several.verdict_rules import PooledVerdict
from diagnosis.verdict import Verdict
from diagnosis.workflow import Examination, diagnosis_of, examine
from recordings import Recording
from scenarios.errors import InputError
from sim.pool import Tasks
from sim.scenario import Model

Progress = Callable[[str], object]


@one_thread()
def diagnose_together(
    names: Sequence[str],
    problems: Sequence[LinearProblem],
    model: Model,
    *,
    without: frozenset[str] = frozenset(),
    cluster: Tasks | None = None,
    say: Progress = lambda step: None,
) -> PooledDiagnosis:
    """Diagnose n recordings of one instrument, compared with one model.

    An effect is accepted where coefficients predicted by the other recordings explain each recording, in nats over all
    recordings (`accepted_pooled`, `coloured_nats` in coloured noise); it transfers where the coefficients agree.

    cluster : examines the recordings, each a task; by default this process does.
    Raises InputError for fewer than two recordings, and for identical samples.
    """
    if len(problems) < 2:
        raise InputError("a single recording cannot be compared", where="recordings", do="give two or more")
    for (name, problem), (other_name, other_problem) in itertools.combinations(zip(names, problems, strict=True), 2):
        check_apart(problem.recording, other_problem.recording, f"{name}, {other_name}")
    tasks = [(name, problem, model, without) for name, problem in zip(names, problems, strict=True)]
    recordings = [PooledRecording.of(examination) for examination in examine_each(tasks, say, cluster)]
    effects, alone = select_pooled(recordings, say)
    say("the simulator with the new models")
    single = tuple(common_effect(effect, [recording.problem for recording in recordings]) for effect in alone)
    each = tuple(diagnosis_of(recording.examination) for recording in recordings)
    return with_sentences(_diagnosis(tuple(names), model, each, PooledVerdict.of(recordings, effects), single))


def _diagnosis(
    names: tuple[str, ...],
    model: Model,
    each: tuple[Diagnosis, ...],
    pooled: PooledVerdict,
    single: tuple[CommonEffect, ...],
) -> PooledDiagnosis:
    """The diagnosis of the pool, without sentences."""
    first, cases = _answers_better_alone(pooled, each), pooled.cases
    sigma_nT = [case.problem.sigma_nT for case in cases]
    return PooledDiagnosis(
        names=names,
        each=each,
        verdict=pooled.verdict if first is None else each[first].verdict,
        common=pooled.common,
        single=single,
        gaps=tuple(case.gap for case in cases),
        where=mean_shares([case.where for case in cases], cases[0].problem.policy),
        unexplained=pooled.unexplained(names),
        model=patch_model(model, [effect.named for effect in pooled.common], cases[0].problem),
        before_nT=tuple(map(np.multiply, pooled.before, sigma_nT)),
        after_nT=tuple(map(np.multiply, (case.residual for case in cases), sigma_nT)),
        first=first,
    )


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
    return with_sentences(_diagnosis_of_sensors(tuple(names), each, compared))


def _diagnosis_of_sensors(
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


Task = tuple[str, LinearProblem, Model, frozenset[str]]
"""A recording to be examined by itself: name, problem, model, and the effects left out."""


@one_thread()
def examine_alone(task: Task) -> Examination:
    """Examine the recording of a task, in a worker."""
    return examine(*task[1:])


def examine_each(tasks: Sequence[Task], say: Progress, cluster: Tasks | None = None) -> list[Examination]:
    """Return the examinations in the order of the tasks, whatever the order in which a cluster computes them."""
    if cluster is None:
        return [
            examine(problem, model, without, lambda step, name=name: say(f"{name}: {step}"))  # type: ignore[misc]
            for name, problem, model, without in tasks
        ]
    found = {}
    for (name, *_), examination in cluster.map(examine_alone, tasks):
        say(f"{name}: examined")
        found[name] = examination
    return [found[name] for name, *_ in tasks]


def check_apart(first: Recording, second: Recording, where: str) -> None:
    """Raise InputError for two identical recordings, which would confirm each other."""
    if np.array_equal(first.mag_nT, second.mag_nT):
        raise InputError(
            "both recordings have the same field samples", where=where, do="give recordings of different times"
        )


def _answers_better_alone(pooled: PooledVerdict, each: Sequence[Diagnosis]) -> int | None:
    """Index of the worst recording where the recordings alone say more than all together; else None.

    Nothing is common to all, and every recording alone has its answer or all together none; or only noise and steps of
    the values are common, and a recording has an effect or iron of its own.
    """
    own_gap = any(one.verdict is not Verdict.NONE for one in each)
    own_cause = any(cause.kind not in OF_VALUES for one in each for cause in one.named)
    better = (own_gap and _is_silent(pooled, each)) or (own_cause and _names_values_only(pooled))
    return worst(each) if better else None


def _is_silent(pooled: PooledVerdict, each: Sequence[Diagnosis]) -> bool:
    answered = all(one.verdict.explained for one in each)
    return pooled.verdict is Verdict.NONE or (pooled.verdict is Verdict.UNKNOWN and answered)


def _names_values_only(pooled: PooledVerdict) -> bool:
    return pooled.verdict.explained and all(effect.named.kind in OF_VALUES for effect in pooled.common)


def mean_shares(shares_of_each: Sequence[Sequence[ChannelShare]], policy: Policy) -> tuple[ChannelShare, ...]:
    """Channels by mean share over the recordings; a recording in which a channel has no share counts as none."""
    frames, total = dict[str, str](), dict[str, float]()
    for name, frame, share in itertools.chain.from_iterable(shares_of_each):
        frames.setdefault(name, frame)
        total[name] = total.get(name, 0.0) + share / len(shares_of_each)
    largest = sorted(total, key=lambda name: -total[name])[: policy.most_channels]
    return tuple(ChannelShare(name, frames[name], total[name]) for name in largest)
