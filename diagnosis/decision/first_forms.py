"""Effects that are looked for with a fuller form from the start: the plain one may explain too little to be found."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

from diagnosis.decision.monotone_courses import channels_of_time
from diagnosis.evidence.baseline import Baseline, IsClean
from diagnosis.evidence.held_out import Evidence, between_listed, judged_at
from diagnosis.library.candidates import Candidate


def fuller(ground: Baseline, members: dict[str, list[Candidate]], is_clean: IsClean) -> tuple[Evidence, ...]:
    """The evidence of every effect that says with which form it is looked for, at the listed values of both.

    The curve of a channel that only rises is any slow course, and is not asked for.
    """
    slow = channels_of_time(ground.problem)
    asked = (
        several for several in members.values() if _first_form(several) and slow.isdisjoint(several[0].effect.needs)
    )
    judged = (judged_at(ground, list(_settings(ground, several))) for several in asked)
    heard = (_curve(ground, one, is_clean) if one.candidate.effect.needs else one for one in judged if one is not None)
    return tuple(one for one in heard if one is not None)


def _curve(ground: Baseline, one: Evidence, is_clean: IsClean) -> Evidence | None:
    """A channel's curve at the lag that fits best, where it leaves nothing: of a slow noise it follows a part."""
    finer = between_listed(ground, one)
    return finer if is_clean(ground.beside(finer.candidate.columns(ground.problem)), finer.name) else None


def _first_form(several: list[Candidate]) -> str:
    return several[0].effect.traits.first_form


def _settings(ground: Baseline, several: list[Candidate]) -> Iterator[Candidate]:
    """Members with the form's listed numbers, a policy's factor larger than their own: of one size both are one.

    A curve is counted from the middle of its course.
    """
    effect, form = several[0].effect, _first_form(several)
    listed = [p for p in effect.forms[form] if p.role == "listed"]
    factor = ground.problem.policy.first_form_factor
    for one in several:
        own = [value for name, value in one.nonlinear if name in effect.search]
        for values in itertools.product(*(p.quantity.tried for p in listed)):
            if all(math.isclose(other, factor * size) for size in own for other in values):
                numbers = dict(zip((p.name for p in listed), values, strict=True))
                yield one.at({**effect.central_reference(ground.problem.state), **numbers}).with_form(form)
