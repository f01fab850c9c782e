"""Changes of the iron against the model, and effects that resemble iron on the recorded motion."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from diagnosis.decision.choice import AcceptedEffect, accept_best
from diagnosis.decision.selection import Selection
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.evidence.held_out import Evidence, rank_candidates
from diagnosis.library.candidates import Candidate, iron_candidates, propose_candidates
from diagnosis.problem.blocks import Cut
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.state import MOTION
from validation.signals.amplitude import rms


class IronChanges(NamedTuple):
    """Changes of the iron: findings, and mere changes of an effect's reference (a temperature, an origin)."""

    changes: tuple[AcceptedEffect, ...] = ()
    conventional: tuple[AcceptedEffect, ...] = ()


def iron_changes(selection: Selection) -> IronChanges:
    """Find iron, offset, scale, axes and rotation that differ from the given model; vector mode only."""
    problem, policy = selection.end.problem, selection.end.problem.policy
    if problem.mode != "vector":
        return IronChanges()
    baseline, accepted = _baseline_without_iron(selection), selection.accepted
    whole = _find_changes(selection, baseline)
    columns = [_reference_columns(effect.evidence, problem) for effect in accepted]
    conventions = np.concatenate([np.zeros((*problem.target.shape, 0)), *columns], axis=2)
    if not conventions.shape[2] or not whole:
        return IronChanges(whole)
    findings = []
    for change in _find_changes(selection, baseline.with_columns(conventions)):
        # constants are compared with constants, matrices with matrices: an error of the slopes leaves a little
        constant = change.evidence.candidate.effect.traits.constant
        alike = (one.evidence.gain for one in whole if one.evidence.candidate.effect.traits.constant == constant)
        if change.evidence.gain >= policy.little**2 * sum(alike):
            findings.append(change)
    names = {change.name for change in findings}
    return IronChanges(tuple(findings), tuple(change for change in whole if change.name not in names))


def _reference_columns(evidence: Evidence, problem: LinearProblem) -> Array:
    """Columns (n, q, k) of the change that another reference of a fitted effect would make; k = 0 without one."""
    effect = evidence.candidate.to_effect(evidence.coefficients)
    return problem.whitened(effect.convention_columns(problem.state, problem.clean_nT), type(effect))


def _find_changes(selection: Selection, baseline: Baseline) -> tuple[AcceptedEffect, ...]:
    """Find changes of the iron on a baseline; alternatives include effects that resemble one on the recorded motion."""
    problem, candidates = selection.end.problem, iron_candidates()
    others, bare = _candidates_without_search(problem, selection.without), baseline
    changes: list[AcceptedEffect] = []
    while len(changes) < problem.policy.most_effects:
        ranking = rank_candidates(baseline, candidates)
        chosen = accept_best(ranking, problem.policy, clean=selection.after.clean)
        if chosen is None or _is_negligible(chosen, changes, selection):
            break
        rivals = rank_candidates(baseline, others)
        best, share = ranking[0], problem.policy.same_iron  # terms of second order in both
        near = (
            each for each in rivals if not each.is_behind(best, problem.policy) or each.gain > (1 - share) * best.gain
        )
        changes.append(chosen.listing(*(each.name for each in near if not _is_conventional(each, problem))))
        baseline = baseline.with_columns(chosen.columns(baseline.problem))
    return tuple(changes) if selection.after.clean else tuple(_beats_coloured_noise(bare, changes))


def _beats_coloured_noise(bare: Baseline, changes: Sequence[AcceptedEffect]) -> Iterator[AcceptedEffect]:
    """The changes of the iron that beat coloured noise, each fitted next to the rest.

    Slow noise on a slow motion resembles iron; the residual of a second change resembles slow noise.
    """
    problem = bare.problem
    for change in changes:
        baseline = bare.with_all(another.columns(problem) for another in changes if another is not change)
        coloured_baseline = ColouredBaseline.of(problem, baseline.accepted_columns)
        fit = coloured_baseline.fit_candidate(change.evidence, coloured_baseline.rows.bin(change.columns(problem)))
        if fit.gain > problem.policy.coloured_nats:
            yield change


def _is_conventional(rival: Evidence, problem: LinearProblem) -> bool:
    """Whether nearly all of an effect's contribution lies in its reference: the effect is then iron.

    Examples are a drift that settles at once, and a hysteresis loop wider than the field. A recorded channel that
    hardly changes may still be the reason why the iron differs.
    """
    if not MOTION.issuperset(rival.candidate.effect.needs):
        return False
    added = (rival.candidate.columns(problem) @ rival.coefficients).ravel()
    A = _reference_columns(rival, problem).reshape(len(added), -1)
    residual = added - A @ np.linalg.lstsq(A, added, rcond=None)[0]
    return bool(np.linalg.norm(residual) < problem.policy.little * np.linalg.norm(added))


def absorbed_effects(problem: LinearProblem) -> tuple[str, ...]:
    """Effects with recorded channels whose columns the base absorbs nearly whole on the motion; vector mode only."""
    if problem.mode != "vector":
        return ()
    several = _candidates_without_search(problem).items()
    return tuple(name for name, (first, *_) in several if survival(problem, first) < problem.policy.little)


def survival(problem: LinearProblem, candidate: Candidate) -> float:
    """``rho = |(I - P_base) E| / |E|`` of a candidate's columns, as means over a second: rates are noisy."""
    columns = candidate.columns(problem)
    length = max(1, round(problem.policy.survival_mean_s / problem.state.interval_s))
    cut = Cut(length, len(columns) // length)
    E, B = cut.means(columns), cut.means(problem.base)
    Q = np.linalg.qr(B / np.linalg.norm(B, axis=0))[0]
    remaining = E - np.einsum("np,pqk->nqk", Q, np.einsum("np,nqk->pqk", Q, E))
    size = float(np.linalg.norm(E))
    return float(np.linalg.norm(remaining)) / size if size > 0 else 0.0


def _baseline_without_iron(selection: Selection) -> Baseline:
    """The baseline of measured minus the given model, with no fitted base, with all accepted effects.

    For an effect with an origin a constant of the earth's frame is added: the origin was found with fitted iron.
    """
    problem = selection.end.problem
    target: Array = (problem.recording.mag_nT - problem.predicted_nT) / problem.sigma_nT * problem.usable[:, None]
    bare = replace(problem, base=np.zeros((len(target), 1)), target=target)
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


def _is_negligible(chosen: AcceptedEffect, changes: list[AcceptedEffect], selection: Selection) -> bool:
    """Whether a change is a form error of accepted effects, within the stated attitude error, or negligible.

    Effects count without fitted iron, but for those whose reference is part of the iron: a sensor at 10 degrees has a
    large part of ``k (T - 20)`` in its iron. Within the iron only rotations have a form error; all else is linear. An
    event outside the training data leaves chance evidence on held-out data.
    """
    problem, policy = selection.end.problem, selection.end.problem.policy
    if chosen.evidence.raw_gain < policy.accepted(len(EFFECTS)):
        return True
    effects = [effect.evidence for effect in selection.accepted]
    larger = [each.gain if _reference_columns(each, problem).shape[2] else each.raw_gain for each in effects]
    larger += [change.evidence.gain for change in changes[:1] if change.evidence.candidate.effect.tangents]
    share = policy.form_share if selection.after.clean else policy.same_form_share
    if chosen.evidence.gain < share**2 * max(larger, default=0.0):
        return True
    turned_nT = policy.somewhat_larger * problem.attitude_std_rad * float(np.linalg.norm(problem.state.field_enu_nT))
    return chosen.evidence.strength < turned_nT / rms(problem.sigma_nT)
