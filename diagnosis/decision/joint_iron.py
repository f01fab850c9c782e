"""Joint fit of effects and iron where only the field's strength is known: each is fitted with the other subtracted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from diagnosis.decision.selection import Progress, Selection, choose_windows_again, select
from diagnosis.evidence.candidate_result import withdraw_names
from diagnosis.problem.blocks import fit
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.strength import refit_iron
from scenarios.arrays import Array
from validation.signals.amplitude import rms


def select_jointly(
    problem: LinearProblem, without: frozenset[str] = frozenset(), say: Progress = lambda what: None
) -> Selection:
    """Run `select`; without attitude, refit the iron without the effects and select again until the target settles.

    The strength is not linear in iron and effects together: accepted effects change the field's direction, and with it
    the iron. Without attitude only; iron with a larger residual is discarded.
    """
    selection = choose_windows_again(select(problem, without, say))
    if problem.mode != "strength":
        return selection
    for _ in range(problem.policy.joint_passes):
        if not selection.accepted:
            break
        anew = refit_iron(problem, disturbance_nT(selection))
        if _target_change(problem, anew) < problem.policy.joint_settled:
            break
        say("iron and effects jointly")
        problem, again = anew, select(anew, without, say)
        if not again.accepted or _residual_rms(again) > problem.policy.larger * max(1.0, _residual_rms(selection)):
            break
        selection = again
    return rejected_if_worse(selection)


def rejected_if_worse(selection: Selection) -> Selection:
    """The selection without effects, where the gap was clean and the residual of the accepted effects is not."""
    if not selection.before.clean or selection.after.clean:
        return selection
    judged = withdraw_names(selection.results, ("what it leaves is not clean, as the gap was",))
    return replace(selection, accepted=(), end=selection.start, after=selection.before, results=judged)


def _residual_rms(selection: Selection) -> float:
    """Rms of the residual, in units of the noise."""
    return rms(selection.end.residual())


def disturbance_nT(selection: Selection) -> Array:
    """Contribution (n, 3) of the accepted effects to the measurement."""
    problem, end = selection.end.problem, selection.end
    c = fit(end.sums, end.all_folds).c
    total, first = np.zeros((len(problem.recording), 3)), 0
    for effect in selection.accepted:
        contribution = effect.evidence.candidate.contribution_nT(problem)
        part = contribution @ c[first : first + contribution.shape[2]]
        total += part @ problem.matrix_behind(effect.evidence.candidate.effect).T
        first += contribution.shape[2]
    return total


def _target_change(before: LinearProblem, after: LinearProblem) -> float:
    """Rms by which the target changes beyond the base, in units of the noise."""
    moved = (after.target - before.target) * before.usable[:, None]
    both = np.concatenate([before.base, after.base], axis=-1)
    flat = both.reshape(-1, both.shape[-1])
    rows = moved.reshape(len(flat), -1)  # outputs with coefficients in common are further rows
    return rms(rows - flat @ np.linalg.lstsq(flat, rows, rcond=1e-10)[0])
