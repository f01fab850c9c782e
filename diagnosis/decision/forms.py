"""The fuller form of an effect that was found: more of its own parameters, where these tell on held-out data."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import minimize

from diagnosis.decision.white_choice import Accepted
from diagnosis.evidence.baseline import Baseline, nats_on_all
from diagnosis.evidence.held_out import Evidence, judged_at, misfit
from diagnosis.evidence.residual_tests import ResidualTests
from diagnosis.library.candidates import Candidate
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects import EFFECTS

Tests = Callable[[Baseline], ResidualTests]
"""(ground with effects in) -> the tests of what it leaves."""


def in_full(found: Sequence[Accepted], start: Baseline, tests: Tests) -> tuple[list[Accepted], Baseline, ResidualTests]:
    """Effects with what their forms lack, the last one's first, until what is left is clean; with ground and tests.

    start : the ground without any effect. A form is no name of its own, and is asked for only where something is left.
    One that was taken for what another effect explains by now is given back.
    """
    out = _with_forms_that_tell(found, start)
    clean = tests(_with(out, start)).clean
    for i in reversed(range(len(out))):
        if not clean:
            out[i], clean = _filled(out, i, start, tests)
    if clean:
        return _as_plain_as_clean(out, start, tests)
    ground = _with(out, start)
    return out, ground, tests(ground)


def _filled(found: Sequence[Accepted], i: int, start: Baseline, tests: Tests) -> tuple[Accepted, bool]:
    """One of several effects with the forms that tell, until what is left is clean, and whether it is."""
    one, clean = found[i], False
    others = _with((*found[:i], *found[i + 1 :]), start)
    while not clean and (fuller := _fuller(others, one.evidence)) is not None:
        one = replace(one, evidence=fuller)
        clean = tests(others.beside(one.columns(start.problem))).clean
    return one, clean


def _with(found: Iterable[Accepted], start: Baseline) -> Baseline:
    """The ground with effects in; of a long recording it is large, and kept no longer than needed."""
    return start.with_all(one.columns(start.problem) for one in found)


def _as_plain_as_clean(
    found: Sequence[Accepted], start: Baseline, tests: Tests
) -> tuple[list[Accepted], Baseline, ResidualTests]:
    """Effects that leave nothing, without the forms that do not tell any more, where these leave nothing either."""
    for each in (_with_forms_that_tell(found, start), list(found)):
        ground = _with(each, start)
        after = tests(ground)
        if after.clean:
            break
    return each, ground, after


def _with_forms_that_tell(found: Sequence[Accepted], start: Baseline) -> list[Accepted]:
    """Effects without those of their forms that gain less than a name needs, beside all the others; each once.

    What was found a second time beside a form is what is left without it.
    """
    out, problem = list(found), start.problem
    for i, one in enumerate(found):
        others = _with((*out[:i], *out[i + 1 :]), start)
        for form in reversed(one.evidence.candidate.forms):
            plainer = judged_at(others, [_without(out[i].evidence.candidate, form)])
            whole = judged_at(others, [out[i].evidence.candidate])
            if plainer is not None and (whole is None or not _tells(whole, plainer, problem)):
                out[i] = replace(out[i], evidence=replace(plainer, gain=one.evidence.gain, V=one.evidence.V))
    return list({_key(one.evidence.candidate): one for one in reversed(out)}.values())[::-1]


def _key(one: Candidate) -> tuple[object, ...]:
    return one.effect, one.forms, repr(sorted(one.nonlinear))


def _without(one: Candidate, form: str) -> Candidate:
    """The candidate without a form, whose parameters are then as they are by default."""
    names = {p.name for p in one.effect.forms[form]}
    kept = tuple((name, value) for name, value in one.nonlinear if name not in names)
    return replace(one, forms=tuple(other for other in one.forms if other != form), nonlinear=kept)


def _tells(fuller: Evidence, plainer: Evidence, problem: LinearProblem) -> bool:
    """Whether a form gains as much as a name needs."""
    return _lead(fuller, plainer) > problem.policy.accepted(len(EFFECTS))


def _lead(fuller: Evidence, plainer: Evidence) -> float:
    """Nats of a form on held-out data, or on all m blocks less ``k / 2 ln m`` for its k columns, whichever is more.

    What it adds at the start alone is an event, which data held out there do not determine.
    """
    k, m = fuller.width - plainer.width, len(fuller.sums.count)
    on_all = nats_on_all(plainer.squares - fuller.squares, fuller.V, k, m)
    return max((fuller.gain - plainer.gain) / fuller.V, on_all)


def _fuller(others: Baseline, one: Evidence) -> Evidence | None:
    """The effect with the form that gains most on held-out data; None where none gains as much as a name needs.

    Its nats stay those of the effect, by which it was chosen.
    """
    before = judged_at(others, [one.candidate])
    asked = [
        judged_at(others, list(_settings(one.candidate, form, others.problem))) for form in _forms_left(one.candidate)
    ]
    judged = [each for each in asked if each is not None]
    if before is None or not judged:
        return None
    best = max(judged, key=lambda each: _lead(each, before))
    if not _tells(best, before, others.problem):
        return None
    finer = judged_at(others, [_between(others, best.candidate)]) or best
    best = max(best, finer, key=lambda each: _lead(each, before))
    return replace(best, gain=one.gain, V=one.V)


def _forms_left(one: Candidate) -> Iterator[str]:
    return (form for form in one.effect.forms if form not in one.forms)


def _settings(one: Candidate, form: str, problem: LinearProblem) -> Iterator[Candidate]:
    """The candidate with a fuller form, at every listed value of that and at every sweep."""
    of_form = one.effect.forms[form]
    grid: dict[str, tuple[Any, ...]] = {p.name: p.quantity.tried for p in of_form if p.role == "listed"}
    fuller = replace(one, forms=(*one.forms, form)).at(one.effect.central_reference(problem.state))
    for values in itertools.product(*grid.values()):
        yield from _swept(fuller.at(dict(zip(grid, values, strict=True))), form, problem)


def _swept(one: Candidate, form: str, problem: LinearProblem) -> Iterator[Candidate]:
    """A candidate at every sweep of its frequency, which stays as it is in the middle; itself where it has none."""
    sweeps = [p for p in one.effect.forms[form] if p.role == "sweep"]
    frequency = one.effect.with_role("frequency")
    if not sweeps or frequency is None:
        yield one
        return
    begin_s, end_s = map(float, problem.state.time_s[[0, -1]])
    for cycles in (sign * ahead for sign in (-1, 1) for ahead in problem.policy.sweep_cycles):
        rate = 2 * cycles / (end_s - begin_s) ** 2
        there = float(dict(one.nonlinear)[frequency]) - rate * (begin_s + end_s) / 2
        if there > 0:
            yield one.at({sweeps[0].name: rate, frequency: there})


def _between(others: Baseline, one: Candidate) -> Candidate:
    """The candidate with its listed numbers, its forms' too, moved together to where the misfit is least."""
    given = dict(one.nonlinear)
    of_forms = (p.name for form in one.forms for p in one.effect.forms[form] if p.role == "listed")
    names = [name for name in (*one.effect.search, *of_forms) if np.ndim(given[name]) == 0 and given[name] > 0]
    if not names:
        return one

    bounds = {p.name: (p.low, p.high) for p in one.effect.parameters()}
    low, high = np.array([bounds[name] for name in names]).T

    def at(x: Array) -> Candidate:
        return one.at(dict(zip(names, map(float, np.clip(np.exp(x), low, high)), strict=True)))

    start, options = np.log([given[name] for name in names]), {"maxfev": others.problem.policy.form_settings}
    best = minimize(lambda x: misfit(others, at(x)), start, method="Nelder-Mead", options={**options, "xatol": 0.02})
    return at(best.x)
