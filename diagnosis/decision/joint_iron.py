"""Effects and iron found jointly where only the field's strength is known: each is fitted with the other out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from diagnosis.decision.selection import Progress, Selection, select
from diagnosis.evidence.candidate_result import taken_back
from diagnosis.problem.blocks import fit
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.strength import about
from scenarios.arrays import Array
from validation.signals.amplitude import rms


def select_jointly(
    problem: LinearProblem, without: frozenset[str] = frozenset(), say: Progress = lambda what: None
) -> Selection:
    """The loop of `select`; without attitude again with the iron fitted beside what was found, until that settles.

    The strength is no linear function of iron and effects together: what was found moves the direction of the field,
    and with it the iron. Without attitude only; iron that leaves more is none.
    """
    selection = select(problem, without, say)
    if problem.mode != "strength":
        return selection
    for _ in range(problem.policy.joint_passes):
        if not selection.found:
            break
        anew = about(problem, disturbance_nT(selection))
        if _moved(problem, anew) < problem.policy.joint_settled:
            break
        say("iron and effects jointly")
        problem, again = anew, select(anew, without, say)
        if not again.found or _left(again) > problem.policy.larger_gap * max(1.0, _left(selection)):
            break
        selection = again
    return without_what_makes_it_worse(selection)


def without_what_makes_it_worse(selection: Selection) -> Selection:
    """Nothing found, where the gap was clean and what the names leave is not."""
    if not selection.before.clean or selection.after.clean:
        return selection
    judged = taken_back(selection.judged, ("what it leaves is not clean, as the gap was",))
    return replace(selection, found=(), end=selection.start, after=selection.before, judged=judged)


def _left(selection: Selection) -> float:
    """Rms of what a selection leaves, in units of its noise."""
    return rms(selection.end.residual())


def disturbance_nT(selection: Selection) -> Array:
    """What the effects that were found add to the measurement (n, 3)."""
    problem, end = selection.end.problem, selection.end
    c = fit(end.sums, end.everything).c
    total, first = np.zeros((len(problem.recording), 3)), 0
    for one in selection.found:
        contribution = one.evidence.candidate.contribution_nT(problem)
        part = contribution @ c[first : first + contribution.shape[2]]
        total += part @ problem.turn_behind(one.evidence.candidate.effect).T
        first += contribution.shape[2]
    return total


def _moved(before: LinearProblem, after: LinearProblem) -> float:
    """Rms by which the target moves beside what the base takes up, in units of the noise."""
    moved = (after.target - before.target) * before.usable[:, None]
    both = np.concatenate([before.base, after.base], axis=-1)
    flat = both.reshape(-1, both.shape[-1])
    rows = moved.reshape(len(flat), -1)  # outputs with coefficients in common are further rows
    return rms(rows - flat @ np.linalg.lstsq(flat, rows, rcond=1e-10)[0])
