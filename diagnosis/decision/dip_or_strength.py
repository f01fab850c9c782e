"""Strength and dip, or the strength alone: which of the two is believed where roll and pitch may err."""

from __future__ import annotations

import numpy as np

from diagnosis.decision.joint_iron import select_jointly
from diagnosis.decision.selection import Progress, Selection
from diagnosis.evidence.reference_checks import by_strength_alone
from diagnosis.problem.linear import LinearProblem


def select_beside_dip(
    problem: LinearProblem, without: frozenset[str] = frozenset(), say: Progress = lambda what: None
) -> Selection:
    """The selection of `select_jointly`, by the strength alone where the dip is off in a way that no name explains.

    An error of roll and pitch turns the field and leaves its strength alone, and a vehicle that speeds up has one. So
    where something is left beside strength and dip, the strength is asked by itself. Its answer is taken where it finds
    something and leaves nothing, or where the two together find nothing and it finds something or has no gap.
    """
    selection = select_jointly(problem, without, say)
    if problem.level is None or selection.after.clean:
        return selection
    say("the strength alone")
    alone = select_jointly(by_strength_alone(selection.end.problem, _off_nT(selection)), without, say)
    clean = alone.after.clean
    taken = (alone.found or clean) if not selection.found else (alone.found and clean)
    return alone if taken else selection


def _off_nT(selection: Selection) -> float:
    """Structure of the dip beyond the noise of a sample, in nT."""
    problem = selection.end.problem
    left = selection.end.residual()[problem.usable > 0, 1]
    return float(np.sqrt(max((left**2).mean() - 1, 0.0)) * problem.sigma_nT[1])
