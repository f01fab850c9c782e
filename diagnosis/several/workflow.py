"""The diagnosis of several recordings, or of the sensors of an array: each by itself, then all together."""

from __future__ import annotations

import itertools
from collections.abc import Sequence, Set
from dataclasses import replace

import numpy as np

from calib.numerics.threads import one_thread
from diagnosis.decision.choice import AcceptedEffect, Selection
from diagnosis.decision.conclusion import conclude
from diagnosis.decision.verdict_rules import judge
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import judge_settings
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.named_effects import named_values
from diagnosis.repair.new_model import patch_model
from diagnosis.result import EvidenceKind, Explanation, Transfer
from diagnosis.several.coefficients import predicted_by_others
from diagnosis.several.common_effects import CommonEffect, common_effect, common_iron_changes, common_value_effects
from diagnosis.several.pooled_effect import PooledEffect
from diagnosis.several.result import SENSORS, PooledDiagnosis, worst
from diagnosis.several.selection import PooledRecording, select_pooled
from diagnosis.several.sentence import with_sentences
from diagnosis.several.transfer import compare_sensors
from diagnosis.verdict import Verdict
from diagnosis.workflow import Examination, Progress, diagnosis_of, examine
from recordings import Recording
from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.pool import Tasks
from sim.scenario import Model


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
    for i, j in itertools.combinations(range(len(problems)), 2):
        check_apart(problems[i].recording, problems[j].recording, f"{names[i]}, {names[j]}")
    tasks = [(name, problem, model, without) for name, problem in zip(names, problems, strict=True)]
    recordings = list(map(PooledRecording.of, _examine_each(tasks, say, cluster)))
    effects, alone = select_pooled(recordings, say)
    say("the simulator with the new models")
    verdict, common, gaps = judge_pool(recordings, effects)
    each = tuple(diagnosis_of(recording.examination) for recording in recordings)
    single = tuple(common_effect(effect, [one.problem for one in recordings]) for effect in alone)
    new = patch_model(model, [effect.named for effect in common], recordings[0].problem)
    return with_sentences(PooledDiagnosis(tuple(names), each, verdict, common, single, gaps, new))


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
    examinations = _examine_each([(*one, without) for one in zip(names, problems, models, strict=True)], say)
    each = tuple(map(diagnosis_of, examinations))
    say("comparison of the sensors")
    named = {cause.name for own in each for cause in own.named if cause.kind is EvidenceKind.HELD_OUT}
    compared, first = _compared_effects(examinations, named), worst(each)
    single = tuple(effect for effect in compared if effect.transfer is Transfer.SINGLE_RUN)
    common = tuple(effect for effect in compared if effect.transfer is not Transfer.SINGLE_RUN)
    told = PooledDiagnosis(
        tuple(names), each, each[first].verdict, common, single, each, each[first].model, SENSORS, first
    )
    return with_sentences(told)


def _compared_effects(examinations: Sequence[Examination], named: Set[str]) -> list[CommonEffect]:
    """Every named effect fitted to all sensors, beside all others, at the setting of the strongest evidence."""
    accepted = [own for examination in examinations for own in examination.selection.accepted if own.name in named]
    problems, compared = [examination.problem for examination in examinations], []
    for name in dict.fromkeys(own.name for own in accepted):
        best = max((own for own in accepted if own.name == name), key=lambda own: own.evidence.nats)
        others = dict.fromkeys(own.evidence.candidate for own in accepted if own.name != name)
        pooled = compare_sensors(PooledEffect.beside(best.evidence.candidate, others, problems))
        compared.append(common_effect(replace(pooled, alternatives=best.alternatives), problems))
    return compared


Task = tuple[str, LinearProblem, Model, frozenset[str]]
"""A recording to be examined by itself: name, problem, model, and the effects left out."""


@one_thread()
def examine_alone(task: Task) -> Examination:
    """Examine the recording of a task, in a worker."""
    return examine(*task[1:])


def _examine_each(tasks: Sequence[Task], say: Progress, cluster: Tasks | None = None) -> list[Examination]:
    """Return the examinations in the order of the tasks, whatever the order in which a cluster computes them."""
    here = ((task, examine(*task[1:], lambda step, name=task[0]: say(f"{name}: {step}"))) for task in tasks)  # type: ignore[misc]
    found = {}
    for (name, *_), examination in here if cluster is None else cluster.map(examine_alone, tasks):
        say(f"{name}: examined")
        found[name] = examination
    return [found[name] for name, *_ in tasks]


def check_apart(first: Recording, second: Recording, where: str) -> None:
    """Raise InputError for two identical recordings, which would confirm each other."""
    if np.array_equal(first.mag_nT, second.mag_nT):
        raise InputError(
            "both recordings have the same field samples", where=where, do="give recordings of different times"
        )


def judge_pool(
    recordings: Sequence[PooledRecording], effects: Sequence[PooledEffect]
) -> tuple[Verdict, tuple[CommonEffect, ...], tuple[Explanation, ...]]:
    """The verdict on all recordings together, their common effects, and what these explain of each recording."""
    conclusions, left = zip(*(_explained(one, i, effects) for i, one in enumerate(recordings)), strict=True)
    common = _common_effects(recordings, effects, conclusions)
    named, cases = [one.named for one in common], []
    for one, conclusion, residual in zip(recordings, conclusions, left, strict=True):
        both, use = (conclusion.start.residual(), residual), one.problem.usable > 0
        cases.append(Explanation.by(one.problem, named, both, use, conclusion.after, clean=conclusion.clean))
    verdict, judged = judge(cases)
    if verdict is Verdict.UNKNOWN:
        common = tuple(effect for effect in common if effect.named.kind is EvidenceKind.DIRECT)
    return verdict, common, judged


def _explained(recording: PooledRecording, i: int, effects: Sequence[PooledEffect]) -> tuple[Selection, Array]:
    """Conclusion of one recording with the pool's effects, and its residual (n, q) with the others' coefficients.

    An effect that does not transfer is fitted together with the recording's iron. Slow noise of unknown nature is none:
    a disturbance following the motion is alike in every recording.
    """
    problem, accepted, baseline = recording.problem, list(recording.events), recording.baseline
    target, fitted = problem.target, list(recording.baseline.accepted_columns)
    for effect in effects:
        if i in effect.possible:
            columns = effect.candidate.columns(problem)
            evidence = judge_settings(baseline, [effect.candidate])
            if evidence is not None:
                accepted.append(AcceptedEffect(evidence, effect.alternatives))
                baseline = baseline.with_columns(columns)
            if effect.transfer is Transfer.NOT_TRANSFERRED:
                fitted.append(columns)
            else:
                target = target - columns @ predicted_by_others(effect.possible)[i]
    selection = replace(recording.examination.selection, accepted=tuple(accepted))
    conclusion = conclude(selection.beside(baseline))
    if conclusion.noise is not None and not conclusion.noise.identified:
        conclusion = replace(conclusion, noise=None)
    return conclusion, Baseline.of(replace(problem, target=target), fitted).residual()


def _common_effects(
    recordings: Sequence[PooledRecording], effects: Sequence[PooledEffect], conclusions: Sequence[Selection]
) -> tuple[CommonEffect, ...]:
    """Effects, changes of the iron, noise and direct evidence supported by more than one recording."""
    problems = [recording.problem for recording in recordings]
    strongest = sorted(effects, key=lambda effect: -effect.strength)
    fitted = [common_effect(one, problems) for one in strongest]
    common = (*fitted, *common_iron_changes([conclusion.iron for conclusion in conclusions], problems))
    others = [effect.named for effect in common]
    values = [
        named_values(conclusion, recording.examination.direct, others)
        for recording, conclusion in zip(recordings, conclusions, strict=True)
    ]
    return (*common, *common_value_effects(values, problems[0].policy))
