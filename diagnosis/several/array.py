"""The sensors of one array: each diagnosed by itself, then what they name compared from sensor to sensor."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from diagnosis.decision.white_choice import Accepted
from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Diagnosis, How
from diagnosis.several.common_effects import Common, common_of
from diagnosis.several.pooled_test import columns_in
from diagnosis.several.result import PooledDiagnosis
from diagnosis.several.scope import SENSORS
from diagnosis.several.selection import joint_of
from diagnosis.several.sentence import advice_of_array, sentence_of_array
from diagnosis.several.transfer import compared
from diagnosis.several.verdict_rules import joined
from diagnosis.several.workflow import mean_shares
from diagnosis.verdict import Verdict
from diagnosis.workflow import Examined, examined, told
from sim.scenario import Model

Progress = Callable[[str], object]


def diagnose_sensors(
    names: Sequence[str],
    problems: Sequence[LinearProblem],
    models: Sequence[Model],
    *,
    without: frozenset[str] = frozenset(),
    say: Progress = lambda what: None,
) -> PooledDiagnosis:
    """Where n sensors of one array disagree with their models, and whether they do so alike.

    Each sensor has a diagnosis of its own; the verdict is that of the worst. Evidence is not summed over them: they
    share the run's slow errors. An effect that any of them names is fitted to all: one coefficient for all is a source
    far off, or something that they share; coefficients that differ are those of a source nearby.
    """
    seen = []
    for name, problem, model in zip(names, problems, models, strict=True):
        seen.append(examined(problem, model, without, lambda what, name=name: say(f"{name}: {what}")))  # type: ignore[misc]
    each = tuple(told(one) for one in seen)
    say("the sensors beside each other")
    found = _told(tuple(names), each, _compared(seen, each))
    return replace(found, sentence=sentence_of_array(found), advice=advice_of_array(found))


def _told(names: tuple[str, ...], each: tuple[Diagnosis, ...], every: Sequence[Common]) -> PooledDiagnosis:
    """The sensors' own diagnoses with what was compared, without words."""
    first = worst(each)
    left = (f"{name}: {why}" for name, one in zip(names, each, strict=True) for why in one.left)
    return PooledDiagnosis(
        names=names,
        each=each,
        verdict=each[first].verdict,
        sentence="",
        common=tuple(one for one in every if one.several),
        single=tuple(one for one in every if not one.several),
        gap=joined([one.gap for one in each]),
        gaps=tuple(one.gap for one in each),
        where=mean_shares([one.where for one in each], each[0].problem.policy),
        left=tuple(left),
        advice=(),
        model=each[first].model,
        before_nT=tuple(one.before_nT for one in each),
        after_nT=tuple(one.after_nT for one in each),
        among=SENSORS,
        first=first,
    )


def worst(each: Sequence[Diagnosis]) -> int:
    """The sensor that leaves most without a cause, else that with the largest gap, in units of its noise."""
    unexplained = [i for i, one in enumerate(each) if not one.verdict.explained]
    if unexplained:
        return max(unexplained, key=lambda i: each[i].gap.after_sigma)
    gaps = [i for i, one in enumerate(each) if one.verdict is not Verdict.NONE]
    return max(gaps or range(len(each)), key=lambda i: each[i].gap.before_sigma)


def _compared(seen: Sequence[Examined], each: Sequence[Diagnosis]) -> list[Common]:
    """What any sensor names, fitted to all of them, each effect beside all others."""
    named = {one.name for own in each for one in own.named if one.how is How.HELD_OUT}
    believed: dict[str, list[Accepted]] = {}
    for one in seen:
        for accepted in one.belief.found:
            if accepted.name in named:
                believed.setdefault(accepted.name, []).append(accepted)
    problems = [one.problem for one in seen]
    return [_common(name, believed, problems) for name in believed]


def _common(name: str, believed: dict[str, list[Accepted]], problems: Sequence[LinearProblem]) -> Common:
    strongest = max(believed[name], key=lambda one: one.evidence.nats)
    settings = list(dict.fromkeys(one.evidence.candidate for one in believed[name]))
    others = {one.evidence.candidate for other in believed if other != name for one in believed[other]}
    besides = []
    for problem in problems:
        columns = [each for other in others if (each := columns_in(other, problem)) is not None]
        besides.append(ColouredBaseline.of(problem, columns))
    joint = joint_of(strongest.evidence.candidate, settings, besides, problems)
    return common_of(compared(joint, problems[0].policy), strongest.alternatives, problems, strongest.evidence.strength)
