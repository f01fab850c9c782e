"""Second passes of the selection: the problem is posed in another way, and the new selection kept if better."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from diagnosis.decision.late_attitude import attitude_in_time, is_late
from diagnosis.decision.selection import Progress, Selection, choose_windows_again, select
from diagnosis.evidence.candidate_result import withdraw_names
from diagnosis.evidence.reference_checks import pose_without_dip
from diagnosis.problem.blocks import fit
from diagnosis.problem.formulation import pose_again, refit_iron
from diagnosis.problem.linear import LinearProblem, ReferenceCorrection
from diagnosis.problem.motion import pauses_after, sample_noise
from scenarios.arrays import Array
from validation.signals.amplitude import rms

OtherProblems = Callable[[Selection], Iterator[tuple[str, LinearProblem]]]
"""(selection) -> its problem posed in other ways, each with its words."""
IsBetter = Callable[[Selection, Selection], bool]
"""(selection, selection of the problem posed in another way) -> whether the second is kept."""


def select_in_every_way(
    problem: LinearProblem, without: frozenset[str] = frozenset(), say: Progress = lambda what: None
) -> Selection:
    """Run `select_jointly`, and again in each of `WAYS` to pose the problem of the selection kept so far."""
    selection = select_jointly(problem, without, say)
    for other_problems, is_better in WAYS:
        for words, posed in other_problems(selection):
            say(words)
            again = select_jointly(posed, without, say)
            if is_better(selection, again):
                selection = again
                break
    return selection


def select_jointly(
    problem: LinearProblem, without: frozenset[str] = frozenset(), say: Progress = lambda what: None
) -> Selection:
    """Run `select`; without attitude, refit the iron without the effects and select again until the target settles.

    The strength is not linear in iron and effects together: accepted effects change the field's direction, and with it
    the iron. Without attitude only; iron with a larger residual is discarded.
    """
    selection = choose_windows_again(select(problem, without, say))
    for _ in range(problem.policy.joint_passes if problem.mode == "strength" else 0):
        if not selection.accepted:
            break
        anew = refit_iron(problem, _disturbance_nT(selection))
        if _target_change(problem, anew) < problem.policy.joint_settled:
            break
        say("iron and effects jointly")
        problem, again = anew, select(anew, without, say)
        left, left_before = (rms(one.end.residual()) for one in (again, selection))
        if not again.accepted or left > problem.policy.larger * max(1.0, left_before):
            break
        selection = again
    return rejected_if_worse(selection) if problem.mode == "strength" else selection


def rejected_if_worse(selection: Selection) -> Selection:
    """The selection without effects, where the gap was clean and the residual of the accepted effects is not."""
    if not selection.before.clean or selection.after.clean:
        return selection
    judged = withdraw_names(selection.results, ("what it leaves is not clean, as the gap was",))
    return replace(selection, accepted=(), end=selection.start, after=selection.before, results=judged)


def _disturbance_nT(selection: Selection) -> Array:
    """Contribution (n, 3) of the accepted effects to the measurement."""
    problem, c = selection.end.problem, fit(selection.end.sums, selection.end.all_folds).c
    total = np.zeros((len(problem.recording), 3))
    for effect in selection.accepted:
        contribution = effect.evidence.candidate.contribution_nT(problem)
        own, c = np.split(c, [contribution.shape[2]])
        total += contribution @ own @ problem.matrix_behind(effect.evidence.candidate.effect).T
    return total


def _target_change(before: LinearProblem, after: LinearProblem) -> float:
    """Rms by which the target changes beyond the base, in units of the noise."""
    moved = (after.target - before.target) * before.usable[:, None]
    both = np.concatenate([before.base, after.base], axis=-1)
    flat = both.reshape(-1, both.shape[-1])
    rows = moved.reshape(len(flat), -1)  # outputs with coefficients in common are further rows
    return rms(rows - flat @ np.linalg.lstsq(flat, rows, rcond=1e-10)[0])


def without_dip(selection: Selection) -> Iterator[tuple[str, LinearProblem]]:
    """Strength alone where strength with dip leaves a residual: errors of roll and pitch turn the field."""
    problem = selection.end.problem
    if problem.level is not None and not selection.after.clean:
        dip = selection.end.residual()[problem.usable > 0, 1]
        dip_nT = float(np.sqrt(max((dip**2).mean() - 1, 0.0)) * problem.sigma_nT[1])
        yield "the strength alone", pose_without_dip(problem, dip_nT)


def _finds_more(selection: Selection, again: Selection) -> bool:
    """Whether a selection finds effects and leaves a clean residual, or either where the first finds nothing."""
    clean = again.after.clean
    return bool(again.accepted and clean) if selection.accepted else bool(again.accepted) or clean


def without_stated_effect(selection: Selection) -> Iterator[tuple[str, LinearProblem]]:
    """The model without one of its effects, where a residual is left: a lag, a place or a threshold may be wrong.

    A second effect of the same name mends a gain alone, since gains add. Iron, noise and the converter stay.
    """
    problem = selection.end.problem
    for effect in problem.effects if problem.turns and not selection.after.clean else ():
        settled = effect.traits.absorbed or effect.traits.converter or effect.stochastic
        if settled or not effect.linear or not set(effect.names()) - set(effect.linear):
            continue
        rest = tuple(other for other in problem.effects if other is not effect)
        done = ReferenceCorrection(
            f"The model's {effect.name} does not fit with any gain; it was left out and looked for anew.",
            f"Take the {effect.name} of the new model instead of the given one: not its size alone is wrong.",
        )
        without = replace(problem, effects=rest, left_out=(*problem.left_out, effect))
        yield (
            f"the model without its {effect.name}",
            pose_again(without, problem.recording, problem.state.field_enu_nT, done),
        )


def _finds_it_anew(selection: Selection, again: Selection) -> bool:
    """Whether the effect left out of the model is accepted anew, and the residual then clean."""
    return again.after.clean and again.start.problem.left_out[-1].name in (effect.name for effect in again.accepted)


def in_noise_left(selection: Selection) -> Iterator[tuple[str, LinearProblem]]:
    """The noise that accepted effects leave, where smaller than taken before: a switched current counts as noise.

    Vector mode only: by strength alone the noise is estimated anew with the iron.
    """
    problem = selection.end.problem
    if problem.mode != "vector" or not selection.accepted:
        return
    used = problem.usable > 0
    residual_nT = selection.end.residual()[used] * problem.sigma_nT
    left_nT = sample_noise(residual_nT, pauses_after(problem.state.time_s[used], problem.policy))
    if (left_nT * problem.policy.larger < problem.sigma_nT).any() and np.isfinite(left_nT).all():
        target = problem.target * (problem.sigma_nT / left_nT)
        yield "the noise anew", replace(problem, target=target, sigma_nT=left_nT)


WAYS: tuple[tuple[OtherProblems, IsBetter], ...] = (
    (without_dip, _finds_more),
    (attitude_in_time, is_late),
    (without_stated_effect, _finds_it_anew),
    (in_noise_left, lambda selection, again: bool(again.accepted)),
)
"""In the order in which they are tried."""
