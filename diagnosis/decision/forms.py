"""Fuller forms of effects, where held-out data support them: further parameters, or a gain for each motor."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import minimize

from diagnosis.decision.choice import AcceptedEffect, Selection, baseline_with
from diagnosis.decision.monotone_courses import monotone_channels
from diagnosis.evidence.baseline import Baseline, IsClean, nats_on_all
from diagnosis.evidence.held_out import Evidence, judge_settings, misfit, refine_listed
from diagnosis.library.candidates import Candidate
from diagnosis.problem.blocks import fit, inflation
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects import EFFECTS


def complete_forms(selection: Selection) -> Selection:
    """Add fuller forms, those of the last effect first, until the residual is clean.

    A form is no cause of its own, and is tried only where the residual is not clean. A form accepted earlier in place
    of a later effect is dropped again.
    """
    start, out = selection.start, _drop_unsupported_forms(selection.accepted, selection.start)
    clean = selection.is_clean(baseline_with(out, start))
    for i in reversed(range(len(out) if not clean else 0)):
        others = baseline_with((*out[:i], *out[i + 1 :]), start)
        while not clean and (fuller := _best_form(others, out[i].evidence)) is not None:
            out[i] = out[i].refitted(fuller)
            clean = selection.is_clean(others.with_columns(out[i].columns(start.problem)))
        del others  # its columns are large for a long recording
    for effects in (_drop_unsupported_forms(out, start), out) if clean else (out,):
        done = replace(selection, accepted=tuple(effects)).beside(baseline_with(effects, start))
        if done.after.clean:
            break
    return done


def _drop_unsupported_forms(accepted: Sequence[AcceptedEffect], start: Baseline) -> list[AcceptedEffect]:
    """Drop forms gaining less than the nats for acceptance next to all remaining effects, and drop duplicate effects.

    A second copy of an effect, accepted next to a form, replaces the first once the form is gone.
    """
    out, needed = list(accepted), start.problem.policy.accepted(len(EFFECTS))
    for i, effect in enumerate(accepted):
        forms = effect.evidence.candidate.forms
        others = baseline_with((*out[:i], *out[i + 1 :]) if forms else (), start)
        for form in reversed(forms):
            candidate = out[i].evidence.candidate
            whole, plainer = (judge_settings(others, [one]) for one in (candidate, _without_form(candidate, form)))
            if plainer is not None and (whole is None or _form_nats(whole, plainer) <= needed):
                out[i] = out[i].refitted(plainer)
        del others
    return list({_key(effect.evidence.candidate): effect for effect in reversed(out)}.values())[::-1]


def _key(candidate: Candidate) -> tuple[object, ...]:
    return candidate.effect, candidate.forms, repr(sorted(candidate.nonlinear))


def _without_form(candidate: Candidate, form: str) -> Candidate:
    """The candidate without a form, whose parameters return to their defaults."""
    own = {p.name for p in candidate.effect.forms[form]}
    kept = tuple(each for each in candidate.nonlinear if each[0] not in own)
    return replace(candidate, forms=tuple(each for each in candidate.forms if each != form), nonlinear=kept)


def _form_nats(fuller: Evidence, plainer: Evidence) -> float:
    """Nats of a form on held-out data, or on all m blocks less ``k / 2 ln m`` for its k columns, whichever is larger.

    Held-out data do not determine an event at the start of the recording.
    """
    k = fuller.width - plainer.width
    on_all = nats_on_all(plainer.squares - fuller.squares, fuller.V, k, fuller.blocks)
    return max((fuller.gain - plainer.gain) / fuller.V, on_all)


def _best_form(others: Baseline, evidence: Evidence) -> Evidence | None:
    """The effect with the form of largest gain on held-out data; None if no form is supported."""
    before, candidate = judge_settings(others, [evidence.candidate]), evidence.candidate
    unused = (form for form in candidate.effect.forms if form not in candidate.forms)
    tried = (judge_settings(others, list(_form_settings(candidate, form, others.problem))) for form in unused)
    fitted = [(_form_nats(fuller, before), fuller) for fuller in tried if fuller is not None and before is not None]
    nats, best = max(fitted, key=lambda each: each[0], default=(0.0, evidence))
    if before is None or nats <= others.problem.policy.accepted(len(EFFECTS)):
        return None
    finer = judge_settings(others, [_refined_settings(others, best.candidate)])
    return finer if finer is not None and _form_nats(finer, before) > nats else best


def _form_settings(candidate: Candidate, form: str, problem: LinearProblem) -> Iterator[Candidate]:
    """The candidate with a fuller form, at every listed value of the form and at every sweep.

    A curve is counted from the middle of its course.
    """
    of_form = candidate.effect.forms[form]
    grid: list[list[dict[str, Any]]] = [
        [{p.name: value} for value in p.quantity.tried] for p in of_form if p.role == "listed"
    ]
    frequency = candidate.effect.with_role("frequency")
    if frequency is not None:
        grid += [_sweeps(candidate, frequency, p.name, problem) for p in of_form if p.role == "sweep"]
    fuller = replace(candidate, forms=(*candidate.forms, form)).at(candidate.effect.central_reference(problem.state))
    for parts in itertools.product(*grid):
        yield fuller.at({name: value for part in parts for name, value in part.items()})


def _sweeps(candidate: Candidate, frequency: str, rate: str, problem: LinearProblem) -> list[dict[str, Any]]:
    """Rates of a candidate's frequency, each with the frequency at time zero, about the frequency in the middle."""
    begin_s, end_s = map(float, problem.state.time_s[[0, -1]])
    cycles = np.outer([-1, 1], problem.policy.sweep_cycles).ravel()
    rates = (2 * cycles / (end_s - begin_s) ** 2).tolist()
    middle_hz = float(dict(candidate.nonlinear)[frequency])
    sweeps = [{rate: each, frequency: middle_hz - each * (begin_s + end_s) / 2} for each in rates]
    return [sweep for sweep in sweeps if sweep[frequency] > 0]


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

    The form's numbers are a factor above the effect's own: at equal size both coincide. The curve of a monotone channel
    fits any slow course and is not tried; of another channel it counts at the best lag, and only where the residual is
    then clean, since a curve also follows a part of slow noise.
    """
    slow, found = monotone_channels(baseline.problem), list[Evidence]()
    for settings in candidates.values():
        effect = settings[0].effect
        if not effect.traits.first_form or not slow.isdisjoint(effect.needs):
            continue
        evidence = judge_settings(baseline, list(_first_form_settings(settings, baseline.problem)))
        if evidence is not None and effect.needs:
            evidence = refine_listed(baseline, evidence)
            with_curve = baseline.with_columns(evidence.candidate.columns(baseline.problem))
            evidence = evidence if is_clean(with_curve, effect.name) else None
        found += [] if evidence is None else [evidence]
    return tuple(found)


def _first_form_settings(settings: Sequence[Candidate], problem: LinearProblem) -> Iterator[Candidate]:
    """Settings with the first form whose numbers are `first_form_factor` times the effect's own."""
    effect, form = settings[0].effect, settings[0].effect.traits.first_form
    listed = [p.name for p in effect.forms[form] if p.role == "listed"]
    for fuller in (each for candidate in settings for each in _form_settings(candidate, form, problem)):
        given, factor = dict(fuller.nonlinear), problem.policy.first_form_factor
        if all(math.isclose(given[name], factor * given[own]) for own in effect.search for name in listed):
            yield fuller


def split_by_motor(selection: Selection) -> Selection:
    """Split effects with one gain for all motors into a gain for each motor, where the residual supports it.

    The split must gain the nats for acceptance on held-out data, over the inflation. Motors explaining nothing are left
    out. An effect accepted earlier is split again once a later effect no longer hides a motor.
    """
    start, out, names = selection.start, list[AcceptedEffect](), selection.names
    motors = start.problem.state.motors
    for i, effect in enumerate(selection.accepted):
        found, parts = effect.evidence, list[Evidence]()
        role = found.candidate.effect.with_role("motor") if names.count(effect.name) == 1 else None
        if role and len(motors) > 1:
            others = baseline_with((*out, *selection.accepted[i + 1 :]), start)
            if not selection.is_clean(others.with_columns(effect.columns(start.problem))):
                parts = _motor_evidence(others, [found.candidate.at({role: motor}) for motor in motors], found)
        if parts:
            effect = effect.refitted(parts[0])
        out += [effect, *(AcceptedEffect(part, ()) for part in parts[1:])]
    return replace(selection, accepted=tuple(out))


def _motor_evidence(others: Baseline, settings: Sequence[Candidate], common: Evidence) -> list[Evidence]:
    """Evidence of each motor next to all remaining effects, the strongest first; empty if the split gains too little.

    Both all motors and the kept ones must gain enough over a common gain: of motors running alike none explains
    anything next to the rest. Held-out data are used for both: a common gain explains less on held-out data where the
    base is extrapolated.
    """
    problem, policy = others.problem, others.problem.policy
    alone = others.held_out_gain(others.sums_with(common.candidate.columns(problem)))

    def explain_more(columns: Sequence[Array]) -> bool:
        joint = others.with_all(columns).sums
        V = inflation(joint, fit(joint, others.all_folds), policy)
        return (others.held_out_gain(joint) - alone) / V > policy.accepted(len(EFFECTS))

    columns, known, kept = [motor.columns(problem) for motor in settings], list[Evidence](), list[Array]()
    for setting, own in zip(settings, columns if explain_more(columns) else (), strict=False):
        motor = judge_settings(others.with_all(other for other in columns if other is not own), [setting])
        if motor is not None and motor.nats > policy.apart:
            known.append(motor)
            kept.append(own)
    return sorted(known, key=lambda motor: -motor.strength) if known and explain_more(kept) else []
