"""Effects searched with a fuller form from the start: the plain form may explain too little to be accepted."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

from diagnosis.decision.monotone_courses import monotone_channels
from diagnosis.evidence.baseline import Baseline, IsClean
from diagnosis.evidence.held_out import Evidence, judge_settings, refine_listed
from diagnosis.library.candidates import Candidate


def first_form_evidence(
    baseline: Baseline, candidates: dict[str, list[Candidate]], is_clean: IsClean
) -> tuple[Evidence, ...]:
    """Evidence of every effect with a first form, at the listed values of effect and form.

    The curve of a monotone channel fits any slow course and is not tried.
    """
    slow = monotone_channels(baseline.problem)
    searched = (
        settings
        for settings in candidates.values()
        if _first_form(settings) and slow.isdisjoint(settings[0].effect.needs)
    )
    fitted = (judge_settings(baseline, list(_settings(baseline, settings))) for settings in searched)
    refined = (
        _refined_curve(baseline, evidence, is_clean) if evidence.candidate.effect.needs else evidence
        for evidence in fitted
        if evidence is not None
    )
    return tuple(evidence for evidence in refined if evidence is not None)


def _refined_curve(baseline: Baseline, evidence: Evidence, is_clean: IsClean) -> Evidence | None:
    """A channel's curve at the best lag, if the residual is clean: a curve also follows a part of slow noise."""
    finer = refine_listed(baseline, evidence)
    return finer if is_clean(baseline.with_columns(finer.candidate.columns(baseline.problem)), finer.name) else None


def _first_form(several: list[Candidate]) -> str:
    return several[0].effect.traits.first_form


def _settings(baseline: Baseline, several: list[Candidate]) -> Iterator[Candidate]:
    """Settings with the form's numbers a factor above the effect's own: at equal size both coincide.

    A curve is counted from the middle of its course.
    """
    effect, form = several[0].effect, _first_form(several)
    listed = [p for p in effect.forms[form] if p.role == "listed"]
    factor = baseline.problem.policy.first_form_factor
    for candidate in several:
        own = [value for name, value in candidate.nonlinear if name in effect.search]
        for values in itertools.product(*(p.quantity.tried for p in listed)):
            if all(math.isclose(other, factor * size) for size in own for other in values):
                numbers = dict(zip((p.name for p in listed), values, strict=True))
                yield candidate.at({**effect.central_reference(baseline.problem.state), **numbers}).with_form(form)
