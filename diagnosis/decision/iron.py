"""What of the iron differs from the model, and which effects look like iron on this motion."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.decision.selection import Selection
from diagnosis.decision.white_choice import Accepted, accepted
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.evidence.held_out import Evidence, ranked
from diagnosis.library.candidates import Candidate, changes_of_iron, proposed
from diagnosis.policy import Policy
from diagnosis.problem.blocks import Cut
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.state import MOTION


@dataclass(frozen=True)
class IronChanges:
    """Changes of the iron: those that are findings, and those that belong to what an effect is counted from."""

    found: tuple[Accepted, ...]
    counted: tuple[Accepted, ...]


def iron_changes(selection: Selection) -> IronChanges:
    """What of the base differs from the model as it was given: iron, offset, scale, axes, turn; vector mode only."""
    if selection.end.problem.mode != "vector":
        return IronChanges((), ())
    ground, conventions = _unfitted(selection), _conventions(selection)
    every = _changes(selection, ground)
    if not conventions.shape[2] or not every:
        return IronChanges(every, ())
    beyond = _changes(selection, ground.beside(conventions))
    names = {one.name for one in beyond}
    return IronChanges(beyond, tuple(one for one in every if one.name not in names))


def _conventions(selection: Selection) -> Array:
    """Columns (n, q, k) by which the effects would differ if they were counted from elsewhere."""
    problem, columns = selection.end.problem, [np.zeros((*selection.end.problem.target.shape, 0))]
    for one in selection.found:
        effect = one.evidence.candidate.made(one.evidence.coefficients)
        columns.append(problem.whitened(effect.convention_columns(problem.state, problem.clean_nT), type(effect)))
    return np.concatenate(columns, axis=2)


def _changes(selection: Selection, ground: Baseline) -> tuple[Accepted, ...]:
    """Changes of the iron on a ground; alternatives are also the effects that look like one on this motion."""
    problem, members = selection.end.problem, changes_of_iron()
    others, bare = _listed(problem, selection.without), ground
    found: list[Accepted] = []
    while len(found) < problem.policy.most_effects:
        ranking = ranked(ground, members)
        chosen = accepted(ranking, problem.policy, clean=selection.after.clean)
        if chosen is None or _is_of_no_account(chosen, found, selection):
            break
        rivals = ranked(ground, others)
        alike = [e for e in rivals if _looks_like(e, ranking[0], problem.policy)]
        others_alike = tuple(e.name for e in alike if not _by_convention(e, problem))
        found.append(replace(chosen, alternatives=(*chosen.alternatives, *others_alike)))
        ground = ground.beside(chosen.columns(ground.problem))
    return tuple(found) if selection.after.clean else tuple(_standing(bare, found))


def _standing(bare: Baseline, found: Sequence[Accepted]) -> Iterator[Accepted]:
    """Those changes of the iron that beat a rest with its own colour, each beside the others.

    Of slow noise a slow motion makes iron; and beside one change alone what another leaves is such a rest.
    """
    problem = bare.problem
    for one in found:
        ground = bare.with_all(other.columns(problem) for other in found if other is not one)
        beside = ColouredBaseline.of(problem, ground.inside)
        standing = beside.standing(one.evidence, beside.rows.taken(one.columns(problem)))
        if standing.gain > problem.policy.coloured_nats:
            yield one


def _looks_like(rival: Evidence, best: Evidence, policy: Policy) -> bool:
    """Whether data do not tell an effect from a change of the iron, but by what is of second order in both."""
    return not rival.behind(best, policy) or rival.gain > (1 - policy.same_iron) * best.gain


def _by_convention(rival: Evidence, problem: LinearProblem) -> bool:
    """Whether all but little of what an effect adds is what it is counted from: it then is the iron by another name.

    So a drift that settles at once, or a loop that is wider than the field. A recorded channel that hardly changes may
    still be why the iron is another.
    """
    if not MOTION.issuperset(rival.candidate.effect.needs):
        return False
    effect, state = rival.candidate.made(rival.coefficients), problem.state
    counted = problem.whitened(effect.convention_columns(state, problem.clean_nT), type(effect))
    added = (rival.candidate.columns(problem) @ rival.coefficients).ravel()
    A = counted.reshape(len(added), -1)
    left = added - A @ np.linalg.lstsq(A, added, rcond=None)[0]
    return bool(np.linalg.norm(left) < problem.policy.absorbed_survival * np.linalg.norm(added))


def absorbed_effects(problem: LinearProblem) -> tuple[str, ...]:
    """Effects that have the channels but that the base takes up nearly whole on this motion; vector mode only."""
    if problem.mode != "vector":
        return ()
    limit = problem.policy.absorbed_survival
    return tuple(name for name, members in _listed(problem).items() if survival(problem, members[0]) < limit)


def survival(problem: LinearProblem, member: Candidate) -> float:
    """``rho = |(I - P_base) E| / |E|`` of a candidate's columns, as means over a second: rates are noisy."""
    columns = member.columns(problem)
    length = max(1, round(problem.policy.survival_mean_s / problem.state.interval_s))
    cut = Cut(length, len(columns) // length)
    E, B = cut.means(columns), cut.means(problem.base)
    Q = np.linalg.qr(B / np.linalg.norm(B, axis=0))[0]
    left = E - np.einsum("np,pqk->nqk", Q, np.einsum("np,nqk->pqk", Q, E))
    size = float(np.linalg.norm(E))
    return float(np.linalg.norm(left)) / size if size > 0 else 0.0


def _unfitted(selection: Selection) -> Baseline:
    """Measured minus the model as given, with no base that is fitted, beside the effects that were found.

    Beside one with an origin also a constant of the earth's frame: the origin was found with the iron fitted.
    """
    problem = selection.end.problem
    target: Array = (problem.recording.mag_nT - problem.predicted_nT) / problem.sigma_nT * problem.usable[:, None]
    bare = replace(problem, base=np.zeros((len(target), 1)), target=target)
    constant = [
        problem.whitened(problem.state.R_wb.transpose(0, 2, 1), one.evidence.candidate.effect)
        for one in selection.found
        if one.evidence.candidate.effect.with_role("origin")
    ]
    return Baseline.of(bare, (*selection.end.inside, *constant[:1]))


def _listed(problem: LinearProblem, without: frozenset[str] = frozenset()) -> dict[str, list[Candidate]]:
    """Candidates that need no search; a linear field is taken at its given origin."""
    listed = (None, "origin")
    return {name: many for name, many in proposed(problem, without).items() if many[0].effect.search_role() in listed}


def _is_of_no_account(chosen: Accepted, found: list[Accepted], selection: Selection) -> bool:
    """Whether a change is but the form of what was found, or no larger than the stated attitude error makes it.

    Of the iron only turns have an error of form, for all else is linear. Or one that adds next to nothing: where an
    event falls out of the training, what it leaves held out is chance.
    """
    problem = selection.end.problem
    if chosen.evidence.raw_gain < problem.policy.accepted(len(EFFECTS)):
        return True
    larger = [_size(one, problem) for one in selection.found]
    larger += [one.evidence.gain for one in found[:1] if one.evidence.candidate.effect.tangents]
    share = problem.policy.form_share if selection.after.clean else problem.policy.same_form_share
    form = share**2 * max(larger, default=0.0)
    return chosen.evidence.gain < form or chosen.evidence.strength < _turned_by(problem)


def _size(one: Accepted, problem: LinearProblem) -> float:
    """Nats that an effect explains where no iron is fitted; beside the iron where that moves what it is counted from.

    A sensor at 10 degrees has a large part of ``k (T - 20)`` in its iron.
    """
    effect = one.evidence.candidate.made(one.evidence.coefficients)
    counted = effect.convention_columns(problem.state, problem.clean_nT).shape[2]
    return one.evidence.gain if counted else one.evidence.raw_gain


def _turned_by(problem: LinearProblem) -> float:
    """Rms that the stated attitude error makes at most, in units of the noise; a smaller change of the base is none."""
    policy, strength_nT = problem.policy, float(np.linalg.norm(problem.state.field_enu_nT))
    turned_nT = policy.stated_margin * problem.attitude_std_rad * strength_nT
    return turned_nT / float(np.sqrt((problem.sigma_nT**2).mean()))
