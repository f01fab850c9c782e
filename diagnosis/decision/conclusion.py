"""Conclusions from a selection, after revisions: effects, changes of the iron, slow noise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from diagnosis.decision.iron import iron_changes
from diagnosis.decision.selection import Selection
from diagnosis.decision.white_choice import AcceptedEffect
from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.evidence.model_noise import states_slow_noise
from diagnosis.evidence.noise_model import NoiseModel
from diagnosis.evidence.residual_tests import ResidualTests
from diagnosis.evidence.slow_noise import SlowNoise, find_slow_noise
from sim.effects import BY_NAME


@dataclass(frozen=True)
class Conclusion:
    """Accepted effects, changes of the iron and slow noise.

    conventional: changes of the iron that restate an effect's reference and are no findings.
    """

    selection: Selection
    accepted: tuple[AcceptedEffect, ...]
    iron: tuple[AcceptedEffect, ...] = ()
    conventional: tuple[AcceptedEffect, ...] = ()
    noise: SlowNoise | None = None

    @property
    def clean(self) -> bool:
        """Whether the residual is white, or explained by slow noise."""
        return self.after.clean or self.noise is not None

    @property
    def after(self) -> ResidualTests:
        """Tests of the residual of the accepted effects."""
        selection = self.selection
        return selection.after if self.accepted or not selection.accepted else selection.before

    @cached_property
    def coloured_noise(self) -> NoiseModel | None:
        """The noise model of a sample beside the accepted effects, if a coloured residual is left; vector mode only."""
        selection, problem = self.selection, self.selection.end.problem
        if problem.mode != "vector" or selection.after.clean or not self.accepted:
            return None
        found = ColouredBaseline.of(problem, selection.end.accepted_columns)
        samples, noise = float(np.median(found.rows.count)), found.hypothesis.noise_model
        return replace(noise, slow=noise.slow / samples)  # a row sums so many samples, over the root of their number


Revision = Callable[[Conclusion], Conclusion]


def conclude(selection: Selection) -> Conclusion:
    """Apply all `REVISIONS` in order to a selection; the main cause comes first."""
    main_first = sorted(selection.accepted, key=lambda effect: (effect.form_of is not None, -effect.evidence.strength))
    conclusion = Conclusion(selection, tuple(main_first))
    for doubt in REVISIONS:
        conclusion = doubt(conclusion)
    return conclusion


def add_slow_noise(conclusion: Conclusion) -> Conclusion:
    """Add slow noise in the residual as a cause, unless small enough for a form error of the first effect.

    With the largest number of effects accepted, a coloured residual may hold a further effect that was never tried.
    """
    selection = conclusion.selection
    if selection.after.clean or len(selection.accepted) == selection.end.problem.policy.most_effects:
        return conclusion
    noise = find_slow_noise(selection.end.problem, selection.end.residual())
    if noise is None or not noise.fits or (conclusion.accepted and not noise.identified):
        return conclusion
    return conclusion if conclusion.accepted and _is_form_error(conclusion) else replace(conclusion, noise=noise)


def _is_form_error(conclusion: Conclusion) -> bool:
    policy = conclusion.selection.end.problem.policy
    return _excess_rms(conclusion) < policy.quarter * conclusion.accepted[0].evidence.strength


def _excess_rms(conclusion: Conclusion) -> float:
    """Rms of the residual beyond the noise of a sample, in its units."""
    return float(np.sqrt(max((conclusion.selection.end.residual() ** 2).mean() - 1, 0.0)))


def add_iron_changes(conclusion: Conclusion) -> Conclusion:
    """Add changes of the iron, where the model's iron is known."""
    if not conclusion.selection.end.problem.iron_known:
        return conclusion
    changes = iron_changes(conclusion.selection)
    return replace(conclusion, iron=changes.changes, conventional=changes.conventional)


def drop_constants_within_wander(conclusion: Conclusion) -> Conclusion:
    """Drop changes of a constant that a slow wander, found or stated by the model, explains by moving the mean.

    Changes that the data do not distinguish from a constant are dropped too; changes far larger than the wander stay.
    """
    problem = conclusion.selection.end.problem
    if conclusion.noise is None and not states_slow_noise(problem):
        return conclusion
    most = problem.policy.tenfold * _excess_rms(conclusion)
    kept = (change for change in conclusion.iron if change.evidence.strength > most or not _may_be_constant(change))
    return replace(conclusion, iron=tuple(kept))


def _may_be_constant(change: AcceptedEffect) -> bool:
    return any(BY_NAME[name].traits.constant for name in (change.name, *change.alternatives))


REVISIONS: tuple[Revision, ...] = (add_slow_noise, add_iron_changes, drop_constants_within_wander)
