"""Fuller forms of effects, where held-out data support them: further parameters, or a gain for each motor."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import minimize

from diagnosis.decision.choice import AcceptedEffect
from diagnosis.decision.monotone_courses import monotone_channels
from diagnosis.evidence.baseline import Baseline, IsClean, nats_on_all
from diagnosis.evidence.held_out import Evidence, judge_settings, misfit, refine_listed
from diagnosis.evidence.residual_tests import ResidualTests
from diagnosis.library.candidates import Candidate
from diagnosis.problem.blocks import fit, inflation
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
    for i in reversed(range(len(out) if not clean else 0)):
        others = _baseline_with((*out[:i], *out[i + 1 :]), start)
        while not clean and (fuller := _best_form(others, out[i].evidence)) is not None:
            out[i] = replace(out[i], evidence=fuller)
            clean = tests(others.with_columns(out[i].columns(start.problem))).clean
    for effects in (_drop_unsupported_forms(out, start), out) if clean else (out,):
        baseline = _baseline_with(effects, start)
        after = tests(baseline)
        if after.clean:
            break
    return effects, baseline, after


def _baseline_with(accepted: Iterable[AcceptedEffect], start: Baseline) -> Baseline:
    """The baseline with effects; large for a long recording, hence kept no longer than needed."""
    return start.with_all(effect.columns(start.problem) for effect in accepted)


def _drop_unsupported_forms(accepted: Sequence[AcceptedEffect], start: Baseline) -> list[AcceptedEffect]:
    """Drop forms gaining less than the nats for acceptance next to all remaining effects, and drop duplicate effects.

    A second copy of an effect, accepted next to a form, replaces the first once the form is gone.
    """
    out, problem = list(accepted), start.problem
    for i, effect in enumerate(accepted):
        forms = effect.evidence.candidate.forms
        others = _baseline_with((*out[:i], *out[i + 1 :]) if forms else (), start)
        for form in reversed(forms):
            whole = judge_settings(others, [out[i].evidence.candidate])
            plainer = judge_settings(others, [_without_form(out[i].evidence.candidate, form)])
            if plainer is not None and (whole is None or not _is_supported(whole, plainer, problem)):
                out[i] = replace(out[i], evidence=replace(plainer, gain=effect.evidence.gain, V=effect.evidence.V))
    return list({_key(effect.evidence.candidate): effect for effect in reversed(out)}.values())[::-1]


def _without_form(candidate: Candidate, form: str) -> Candidate:
    """The candidate without a form, whose parameters return to their defaults."""
    own = {p.name for p in candidate.effect.forms[form]}
    kept = tuple(each for each in candidate.nonlinear if each[0] not in own)
    return replace(candidate, forms=tuple(each for each in candidate.forms if each != form), nonlinear=kept)


def _key(candidate: Candidate) -> tuple[object, ...]:
    return candidate.effect, candidate.forms, repr(sorted(candidate.nonlinear))


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
    before, candidate = judge_settings(others, [evidence.candidate]), evidence.candidate
    unused = (form for form in candidate.effect.forms if form not in candidate.forms)
    tried = (judge_settings(others, list(_form_settings(candidate, form, others.problem))) for form in unused)
    fitted = [fuller for fuller in tried if fuller is not None]
    if before is None or not fitted:
        return None
    best = max(fitted, key=lambda fuller: _form_nats(fuller, before))
    if not _is_supported(best, before, others.problem):
        return None
    finer = judge_settings(others, [_refined_settings(others, best.candidate)]) or best
    best = max(best, finer, key=lambda fuller: _form_nats(fuller, before))
    return replace(best, gain=evidence.gain, V=evidence.V)


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


def first_form_evidence(
    baseline: Baseline, candidates: dict[str, list[Candidate]], is_clean: IsClean
) -> tuple[Evidence, ...]:
    """Evidence of every effect searched with a fuller form from the start: the plain form may explain too little.

    The curve of a monotone channel fits any slow course and is not tried; of another channel it counts at the best lag,
    and only where the residual is then clean, since a curve also follows a part of slow noise.
    """
    slow, found = monotone_channels(baseline.problem), []
    for settings in candidates.values():
        effect = settings[0].effect
        if not effect.traits.first_form or not slow.isdisjoint(effect.needs):
            continue
        evidence = judge_settings(baseline, list(_first_form_settings(settings, baseline.problem)))
        if evidence is not None and effect.needs:
            evidence = refine_listed(baseline, evidence)
            with_curve = baseline.with_columns(evidence.candidate.columns(baseline.problem))
            evidence = evidence if is_clean(with_curve, effect.name) else None
        if evidence is not None:
            found.append(evidence)
    return tuple(found)


def _first_form_settings(settings: Sequence[Candidate], problem: LinearProblem) -> Iterator[Candidate]:
    """Settings with the form's numbers a factor above the effect's own: at equal size both coincide.

    A curve is counted from the middle of its course.
    """
    effect, form = settings[0].effect, settings[0].effect.traits.first_form
    listed = [p.name for p in effect.forms[form] if p.role == "listed"]
    for fuller in (each for candidate in settings for each in _form_settings(candidate, form, problem)):
        given, factor = dict(fuller.nonlinear), problem.policy.first_form_factor
        if all(math.isclose(given[name], factor * given[own]) for own in effect.search for name in listed):
            yield fuller


def split_by_motor(accepted: Sequence[AcceptedEffect], start: Baseline, tests: ResidualTester) -> list[AcceptedEffect]:
    """Split effects with one gain for all motors into a gain for each motor, where the residual supports it.

    The split must gain the nats for acceptance on held-out data, over the inflation. Motors explaining nothing are left
    out. An effect accepted earlier is split again once a later effect no longer hides a motor. start : the baseline
    without effects.
    """
    out, motors, names = list[AcceptedEffect](), start.problem.state.motors, [effect.name for effect in accepted]
    for i, effect in enumerate(accepted):
        found, rest = effect.evidence, accepted[i + 1 :]
        role = found.candidate.effect.with_role("motor") if names.count(effect.name) == 1 else None
        parts = _parts((*out, *rest), effect, role, start, tests) if role and len(motors) > 1 else []
        first = [replace(effect, evidence=replace(part, gain=found.gain, V=found.V)) for part in parts[:1]]
        out += [*first, *(AcceptedEffect(part, ()) for part in parts[1:])] or [effect]
    return out


def _parts(
    accepted: Iterable[AcceptedEffect], effect: AcceptedEffect, role: str, start: Baseline, tests: ResidualTester
) -> list[Evidence]:
    """The motors of one effect that the data support next to all remaining effects; empty where one gain will do."""
    others = _baseline_with(accepted, start)
    if tests(others.with_columns(effect.columns(start.problem))).clean:
        return []
    settings = [effect.evidence.candidate.at({role: motor}) for motor in start.problem.state.motors]
    return motor_evidence(others, settings, effect.evidence)


def motor_evidence(others: Baseline, settings: Sequence[Candidate], evidence: Evidence) -> list[Evidence]:
    """Evidence of each motor next to all remaining effects, the strongest first; empty if the split gains too little.

    Both all motors and the kept ones must gain enough: of motors running alike none explains anything next to the rest.
    """
    policy, columns = others.problem.policy, [motor.columns(others.problem) for motor in settings]
    if not _explain_more(others, columns, evidence):
        return []
    judged = (
        judge_settings(others.with_all(other for other in columns if other is not own), [setting])
        for setting, own in zip(settings, columns, strict=True)
    )
    known = [motor for motor in judged if motor is not None and motor.nats > policy.apart]
    if not known or not _explain_more(others, [motor.candidate.columns(others.problem) for motor in known], evidence):
        return []
    return sorted(known, key=lambda motor: -motor.strength)


def _explain_more(others: Baseline, columns: Sequence[Array], evidence: Evidence) -> bool:
    """Whether columns (n, q, k) of several motors gain enough more on held-out data than a common gain.

    Held-out data are used for both: a common gain explains less on held-out data where the base is extrapolated.
    """
    policy, common = others.problem.policy, evidence.candidate.columns(others.problem)
    joint, alone = (others.sums_with(each) for each in (np.concatenate(columns, axis=2), common))
    V = inflation(joint, fit(joint, others.all_folds), policy)
    return (others.held_out_gain(joint) - others.held_out_gain(alone)) / V > policy.accepted(len(EFFECTS))
