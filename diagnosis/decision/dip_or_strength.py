"""Choice between strength with dip and strength alone, where roll and pitch may err."""

from __future__ import annotations

import numpy as np

from diagnosis.decision.joint_iron import select_jointly
from diagnosis.decision.selection import Progress, Selection
from diagnosis.evidence.reference_checks import pose_without_dip
from diagnosis.problem.linear import LinearProblem


def select_with_dip(
    problem: LinearProblem, without: frozenset[str] = frozenset(), say: Progress = lambda what: None
) -> Selection:
    """Run `select_jointly`, by strength alone where an unexplained error of the dip remains.

    An error of roll and pitch (as under acceleration) turns the field and leaves its strength unchanged. Where strength
    and dip together leave a residual, strength alone is tried: accepted if it finds effects and leaves a clean
    residual, or where strength and dip find nothing and strength alone finds effects or has no gap.
    """
    selection = select_jointly(problem, without, say)
    if problem.level is None or selection.after.clean:
        return selection
    say("the strength alone")
    alone = select_jointly(pose_without_dip(selection.end.problem, _dip_structure_nT(selection)), without, say)
    clean = alone.after.clean
    taken = (alone.accepted or clean) if not selection.accepted else (alone.accepted and clean)
    return alone if taken else selection


def _dip_structure_nT(selection: Selection) -> float:
    """Structure of the dip beyond the noise of a sample, in nT."""
    problem = selection.end.problem
    residual = selection.end.residual()[problem.usable > 0, 1]
    return float(np.sqrt(max((residual**2).mean() - 1, 0.0)) * problem.sigma_nT[1])
