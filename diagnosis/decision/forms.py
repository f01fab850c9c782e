"""Fuller forms of accepted effects: further parameters of an effect, where held-out data support them."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import minimize

from diagnosis.decision.white_choice import AcceptedEffect
from diagnosis.evidence.baseline import Baseline, nats_on_all
from diagnosis.evidence.held_out import Evidence, judge_settings, misfit
from diagnosis.evidence.residual_tests import ResidualTests
from diagnosis.library.candidates import Candidate
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects import EFFECTS

ResidualTester = Callable[[Baseline], ResidualTests]
"""(baseline with effects) -> tests of its residual."""


def complete_forms(
    accepted: Sequence[AcceptedEffect], start: Baseline, tests: ResidualTester
) -> tuple[list[AcceptedEffect], Baseline, ResidualTests]:
    """Add fuller forms, those of the last effect first, until the residual is clean; return effects, baseline, tests.

    start : the baseline without effects. A form is no cause of its own, and is tried only where the residual is not
    clean. A form accepted earlier in place of a later effect is dropped again.
    """
    out = _drop_unsupported_forms(accepted, start)
    clean = tests(_baseline_with(out, start)).clean
    for i in reversed(range(len(out))):
        if not clean:
            out[i], clean = _add_forms(out, i, start, tests)
    if clean:
        return _drop_needless_forms(out, start, tests)
    baseline = _baseline_with(out, start)
    return out, baseline, tests(baseline)


def _add_forms(
    accepted: Sequence[AcceptedEffect], i: int, start: Baseline, tests: ResidualTester
) -> tuple[AcceptedEffect, bool]:
    """Add supported forms to one of several effects until the residual is clean; return effect and cleanness."""
    effect, clean = accepted[i], False
    others = _baseline_with((*accepted[:i], *accepted[i + 1 :]), start)
    while not clean and (fuller := _best_form(others, effect.evidence)) is not None:
        effect = replace(effect, evidence=fuller)
        clean = tests(others.with_columns(effect.columns(start.problem))).clean
    return effect, clean


def _baseline_with(accepted: Iterable[AcceptedEffect], start: Baseline) -> Baseline:
    """The baseline with effects; large for a long recording, hence kept no longer than needed."""
    return start.with_all(effect.columns(start.problem) for effect in accepted)


def _drop_needless_forms(
    accepted: Sequence[AcceptedEffect], start: Baseline, tests: ResidualTester
) -> tuple[list[AcceptedEffect], Baseline, ResidualTests]:
    """Drop unsupported forms from effects with a clean residual, where the residual stays clean."""
    for candidates in (_drop_unsupported_forms(accepted, start), list(accepted)):
        baseline = _baseline_with(candidates, start)
        after = tests(baseline)
        if after.clean:
            break
    return candidates, baseline, after


def _drop_unsupported_forms(accepted: Sequence[AcceptedEffect], start: Baseline) -> list[AcceptedEffect]:
    """Drop forms gaining less than the nats for acceptance next to all remaining effects, and drop duplicate effects.

    A second copy of an effect, accepted next to a form, replaces the first once the form is gone.
    """
    out, problem = list(accepted), start.problem
    for i, effect in enumerate(accepted):
        others = _baseline_with((*out[:i], *out[i + 1 :]), start)
        for form in reversed(effect.evidence.candidate.forms):
            plainer = judge_settings(others, [_without_form(out[i].evidence.candidate, form)])
            whole = judge_settings(others, [out[i].evidence.candidate])
            if plainer is not None and (whole is None or not _is_supported(whole, plainer, problem)):
                out[i] = replace(out[i], evidence=replace(plainer, gain=effect.evidence.gain, V=effect.evidence.V))
    return list({_key(effect.evidence.candidate): effect for effect in reversed(out)}.values())[::-1]


def _key(candidate: Candidate) -> tuple[object, ...]:
    return candidate.effect, candidate.forms, repr(sorted(candidate.nonlinear))


def _without_form(candidate: Candidate, form: str) -> Candidate:
    """The candidate without a form, whose parameters return to their defaults."""
    names = {p.name for p in candidate.effect.forms[form]}
    kept = tuple((name, value) for name, value in candidate.nonlinear if name not in names)
    return replace(
        candidate, forms=tuple(kept_form for kept_form in candidate.forms if kept_form != form), nonlinear=kept
    )


def _is_supported(fuller: Evidence, plainer: Evidence, problem: LinearProblem) -> bool:
    """Whether a form gains the nats needed for acceptance."""
    return _form_nats(fuller, plainer) > problem.policy.accepted(len(EFFECTS))


def _form_nats(fuller: Evidence, plainer: Evidence) -> float:
    """Nats of a form on held-out data, or on all m blocks less ``k / 2 ln m`` for its k columns, whichever is larger.

    Held-out data do not determine an event at the start of the recording.
    """
    k, m = fuller.width - plainer.width, len(fuller.sums.count)
    on_all = nats_on_all(plainer.squares - fuller.squares, fuller.V, k, m)
    return max((fuller.gain - plainer.gain) / fuller.V, on_all)


def _best_form(others: Baseline, evidence: Evidence) -> Evidence | None:
    """The effect with the form of largest gain on held-out data; None if no form is supported.

    The nats stay those by which the effect was accepted.
    """
    before = judge_settings(others, [evidence.candidate])
    tried = [
        judge_settings(others, list(_form_settings(evidence.candidate, form, others.problem)))
        for form in _unused_forms(evidence.candidate)
    ]
    fitted = [form_evidence for form_evidence in tried if form_evidence is not None]
    if before is None or not fitted:
        return None
    best = max(fitted, key=lambda form_evidence: _form_nats(form_evidence, before))
    if not _is_supported(best, before, others.problem):
        return None
    finer = judge_settings(others, [_refined_settings(others, best.candidate)]) or best
    best = max(best, finer, key=lambda form_evidence: _form_nats(form_evidence, before))
    return replace(best, gain=evidence.gain, V=evidence.V)


def _unused_forms(candidate: Candidate) -> Iterator[str]:
    return (form for form in candidate.effect.forms if form not in candidate.forms)


def _form_settings(candidate: Candidate, form: str, problem: LinearProblem) -> Iterator[Candidate]:
    """The candidate with a fuller form, at every listed value of the form and at every sweep."""
    of_form = candidate.effect.forms[form]
    grid: dict[str, tuple[Any, ...]] = {p.name: p.quantity.tried for p in of_form if p.role == "listed"}
    fuller = replace(candidate, forms=(*candidate.forms, form)).at(candidate.effect.central_reference(problem.state))
    for values in itertools.product(*grid.values()):
        yield from _swept(fuller.at(dict(zip(grid, values, strict=True))), form, problem)


def _swept(candidate: Candidate, form: str, problem: LinearProblem) -> Iterator[Candidate]:
    """A candidate at every sweep of its frequency about the frequency in the middle; unchanged if it has no sweep."""
    sweeps = [p for p in candidate.effect.forms[form] if p.role == "sweep"]
    frequency = candidate.effect.with_role("frequency")
    if not sweeps or frequency is None:
        yield candidate
        return
    begin_s, end_s = map(float, problem.state.time_s[[0, -1]])
    for cycles in (sign * ahead for sign in (-1, 1) for ahead in problem.policy.sweep_cycles):
        rate = 2 * cycles / (end_s - begin_s) ** 2
        start_frequency = float(dict(candidate.nonlinear)[frequency]) - rate * (begin_s + end_s) / 2
        if start_frequency > 0:
            yield candidate.at({sweeps[0].name: rate, frequency: start_frequency})


def _refined_settings(others: Baseline, candidate: Candidate) -> Candidate:
    """The candidate with all listed numbers, including those of its forms, moved jointly to the smallest misfit."""
    given = dict(candidate.nonlinear)
    of_forms = (p.name for form in candidate.forms for p in candidate.effect.forms[form] if p.role == "listed")
    names = [name for name in (*candidate.effect.search, *of_forms) if np.ndim(given[name]) == 0 and given[name] > 0]
    if not names:
        return candidate

    bounds = {p.name: (p.low, p.high) for p in candidate.effect.parameters()}
    low, high = np.array([bounds[name] for name in names]).T

    def at(x: Array) -> Candidate:
        return candidate.at(dict(zip(names, map(float, np.clip(np.exp(x), low, high)), strict=True)))

    start, options = np.log([given[name] for name in names]), {"maxfev": others.problem.policy.form_settings}
    best = minimize(lambda x: misfit(others, at(x)), start, method="Nelder-Mead", options={**options, "xatol": 0.02})
    return at(best.x)
