"""Conclusions from a selection, after revisions: changes of the iron against the model, and slow noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from diagnosis.decision.choice import AcceptedEffect, Selection, accept_best
from diagnosis.evidence.along_field import states_slow_noise
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.evidence.held_out import Evidence, rank_candidates
from diagnosis.evidence.slow_noise import SlowNoise, find_slow_noise
from diagnosis.library.candidates import Candidate, iron_candidates, propose_candidates
from diagnosis.problem.blocks import Cut
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects import BY_NAME, EFFECTS
from sim.state import MOTION
from validation.signals.amplitude import rms


def conclude(selection: Selection) -> Selection:
    """The selection with the main cause first, slow noise, and changes of the iron where the model knows the iron."""
    order = sorted(selection.accepted, key=lambda effect: (effect.form_of is not None, -effect.evidence.strength))
    main_first, problem = replace(selection, accepted=tuple(order)), selection.end.problem
    noise = slow_noise(main_first)
    iron, conventional = iron_changes(selection) if problem.iron_known else ((), ())
    if noise is not None or states_slow_noise(problem):
        iron = beyond_wander(iron, selection, noise)
    return replace(main_first, iron=tuple(iron), conventional=tuple(conventional), noise=noise)


def slow_noise(selection: Selection) -> SlowNoise | None:
    """Slow noise in the residual as a cause; beside effects only if identified, and no form error of the first.

    With the largest number of effects accepted, a coloured residual may hold a further effect that was never tried.
    """
    problem, accepted = selection.end.problem, selection.accepted
    if selection.after.clean or len(accepted) == problem.policy.most_effects:
        return None
    noise = find_slow_noise(problem, selection.end.residual())
    form = noise and accepted and (not noise.identified or is_form_error(selection, accepted[0]))
    return None if form else noise


def is_form_error(selection: Selection, first: AcceptedEffect) -> bool:
    """Whether the residual is small enough for a form error of the first effect."""
    return _excess_rms(selection) < selection.end.problem.policy.quarter * first.evidence.strength


def _excess_rms(selection: Selection) -> float:
    """Rms of the residual beyond the noise of a sample, in its units."""
    return float(np.sqrt(max((selection.end.residual() ** 2).mean() - 1, 0.0)))


def beyond_wander(
    iron: Sequence[AcceptedEffect], selection: Selection, noise: SlowNoise | None
) -> tuple[AcceptedEffect, ...]:
    """Changes of the iron that a slow wander, found or stated by the model, does not make by moving the mean.

    Constants, and changes that the data do not distinguish from a constant, stay only where far larger than the mean of
    the noise, or than a stated wander itself.
    """
    wander = _excess_rms(selection) if noise is None else noise.mean_std
    most = selection.end.problem.policy.tenfold * wander

    def may_be_constant(change: AcceptedEffect) -> bool:
        return any(BY_NAME[name].traits.constant for name in (change.name, *change.alternatives))

    return tuple(change for change in iron if change.evidence.strength > most or not may_be_constant(change))


class IronChanges(NamedTuple):
    """Changes of the iron: findings, and mere changes of an effect's reference (a temperature, an origin)."""

    changes: tuple[AcceptedEffect, ...] = ()
    conventional: tuple[AcceptedEffect, ...] = ()


def iron_changes(selection: Selection) -> IronChanges:
    """Find iron, offset, scale, axes and rotation that differ from the given model; vector mode only."""
    problem, policy = selection.end.problem, selection.end.problem.policy
    if problem.mode != "vector":
        return IronChanges()
    baseline = _baseline_without_iron(selection)
    whole = _find_changes(selection, baseline)
    columns = [_reference_columns(effect.evidence, problem) for effect in selection.accepted]
    conventions = np.concatenate([np.zeros((*problem.target.shape, 0)), *columns], axis=2)
    if not conventions.shape[2] or not whole:
        return IronChanges(whole)
    findings = list[AcceptedEffect]()
    for change in _find_changes(selection, baseline.with_columns(conventions)):
        # constants are compared with constants, matrices with matrices: an error of the slopes leaves a little
        alike = (one.evidence.gain for one in whole if _is_constant(one) == _is_constant(change))
        findings += [change] if change.evidence.gain >= policy.little**2 * sum(alike) else []
    names = {change.name for change in findings}
    return IronChanges(tuple(findings), tuple(change for change in whole if change.name not in names))


def _is_constant(change: AcceptedEffect) -> bool:
    return change.evidence.candidate.effect.traits.constant


def _reference_columns(evidence: Evidence, problem: LinearProblem) -> Array:
    """Columns (n, q, k) of the change that another reference of a fitted effect would make; k = 0 without one."""
    effect = evidence.candidate.to_effect(evidence.coefficients)
    return problem.whitened(effect.convention_columns(problem.state, problem.clean_nT), type(effect))


def _find_changes(selection: Selection, bare: Baseline) -> tuple[AcceptedEffect, ...]:
    """Find changes of the iron on a baseline; alternatives include effects that resemble one on the recorded motion.

    In a coloured residual only those that beat coloured noise, each fitted next to the rest: slow noise on a slow
    motion resembles iron, and the residual of a second change resembles slow noise.
    """
    problem, policy, clean = selection.end.problem, selection.end.problem.policy, selection.after.clean
    others, baseline, changes = _candidates_without_search(problem, selection.without), bare, list[AcceptedEffect]()
    while len(changes) < policy.most_effects:
        ranking = rank_candidates(baseline, iron_candidates())
        chosen = accept_best(ranking, policy, clean=clean)
        if chosen is None or _is_negligible(chosen, changes, selection):
            break
        best, least = ranking[0], (1 - policy.same_iron) * ranking[0].gain  # terms of second order in both
        near = (one for one in rank_candidates(baseline, others) if one.gain > least or not one.is_behind(best, policy))
        changes.append(chosen.listing(*(one.name for one in near if not _is_conventional(one, problem))))
        baseline = baseline.with_columns(chosen.columns(problem))
    return tuple(change for change in changes if clean or _beats_coloured_noise(change, changes, bare))


def _beats_coloured_noise(change: AcceptedEffect, changes: Sequence[AcceptedEffect], bare: Baseline) -> bool:
    """Whether a change of the iron next to the other changes beats coloured noise."""
    columns = [another.columns(bare.problem) for another in changes if another is not change]
    beside = ColouredBaseline.of(bare.problem, (*bare.accepted_columns, *columns))
    fit = beside.fit_candidate(change.evidence, beside.columns_of(change.evidence.candidate))
    return fit.gain > bare.problem.policy.coloured_nats


def _is_conventional(rival: Evidence, problem: LinearProblem) -> bool:
    """Whether nearly all of an effect's contribution lies in its reference, as of a drift that settles at once."""
    if not MOTION.issuperset(rival.candidate.effect.needs):
        return False  # a channel that hardly changes may be the reason why the iron differs
    added = (rival.candidate.columns(problem) @ rival.coefficients).ravel()
    A = _reference_columns(rival, problem).reshape(len(added), -1)
    residual = added - A @ np.linalg.lstsq(A, added, rcond=None)[0]
    return bool(np.linalg.norm(residual) < problem.policy.little * np.linalg.norm(added))


def absorbed_effects(problem: LinearProblem) -> tuple[str, ...]:
    """Effects with recorded channels whose columns the base absorbs nearly whole on the motion; vector mode only."""
    several = _candidates_without_search(problem).items() if problem.mode == "vector" else ()
    return tuple(name for name, (first, *_) in several if survival(problem, first) < problem.policy.little)


def survival(problem: LinearProblem, candidate: Candidate) -> float:
    """``rho = |(I - P_base) E| / |E|`` of a candidate's columns, as means over a second: rates are noisy."""
    columns = candidate.columns(problem)
    length = max(1, round(problem.policy.survival_mean_s / problem.state.interval_s))
    cut = Cut(length, len(columns) // length)
    E, B = cut.means(columns.reshape(len(columns), -1)), cut.means(problem.base)
    B = B / np.linalg.norm(B, axis=0)
    left, size = np.linalg.norm(E - B @ np.linalg.lstsq(B, E, rcond=None)[0]), np.linalg.norm(E)
    return float(left / size) if size > 0 else 0.0


def _baseline_without_iron(selection: Selection) -> Baseline:
    """The baseline of measured minus the given model, with no fitted base, with all accepted effects."""
    problem = selection.end.problem
    target: Array = (problem.recording.mag_nT - problem.predicted_nT) / problem.sigma_nT * problem.usable[:, None]
    bare = replace(problem, base=np.zeros((len(target), 1)), target=target)
    # an origin was found with fitted iron
    constant = [
        problem.whitened(problem.state.R_wb.transpose(0, 2, 1), effect.evidence.candidate.effect)
        for effect in selection.accepted
        if effect.evidence.candidate.effect.with_role("origin")
    ]
    return Baseline.of(bare, (*selection.end.accepted_columns, *constant[:1]))


def _candidates_without_search(
    problem: LinearProblem, without: frozenset[str] = frozenset()
) -> dict[str, list[Candidate]]:
    """Candidates without a search; a linear field is taken at its given origin."""
    several = propose_candidates(problem, without).items()
    return {name: many for name, many in several if many[0].effect.search_role() in (None, "origin")}


def _is_negligible(chosen: AcceptedEffect, changes: Sequence[AcceptedEffect], selection: Selection) -> bool:
    """Whether a change is a form error of accepted effects, within the stated attitude error, or negligible.

    Effects count without fitted iron, but for those whose reference is part of the iron: a sensor at 10 degrees has a
    large part of ``k (T - 20)`` in its iron. Within the iron only rotations have a form error; all else is linear. An
    event outside the training data leaves chance evidence on held-out data.
    """
    problem, policy, change = selection.end.problem, selection.end.problem.policy, chosen.evidence
    effects = [effect.evidence for effect in selection.accepted]
    larger = [each.gain if _reference_columns(each, problem).shape[2] else each.raw_gain for each in effects]
    larger += [before.evidence.gain for before in changes[:1] if before.evidence.candidate.effect.tangents]
    share = policy.form_share if selection.after.clean else policy.same_form_share
    turned_nT = policy.somewhat_larger * problem.attitude_std_rad * float(np.linalg.norm(problem.state.field_enu_nT))
    return (
        change.raw_gain < policy.accepted(len(EFFECTS))
        or change.gain < share**2 * max(larger, default=0.0)
        or change.strength < turned_nT / rms(problem.sigma_nT)
    )
