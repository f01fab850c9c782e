"""Conclusions from a selection, after revisions: effects, changes of the iron, slow noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from diagnosis.decision.choice import AcceptedEffect
from diagnosis.decision.iron import iron_changes
from diagnosis.decision.selection import Selection
from diagnosis.evidence.along_field import states_slow_noise
from diagnosis.evidence.candidate_test import ColouredBaseline
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


def conclude(selection: Selection) -> Conclusion:
    """The conclusion from a selection: effects, the main cause first, slow noise and changes of the iron beside them.

    The iron is asked for only where the model knows it.
    """
    problem, effects = selection.end.problem, selection.accepted
    main_first = tuple(sorted(effects, key=lambda effect: (effect.form_of is not None, -effect.evidence.strength)))
    noise = slow_noise(selection, main_first)
    iron, conventional = iron_changes(selection) if problem.iron_known else ((), ())
    if noise is not None or states_slow_noise(problem):
        iron = beyond_wander(iron, selection)
    return Conclusion(selection, main_first, iron, conventional, noise)


def slow_noise(selection: Selection, accepted: Sequence[AcceptedEffect]) -> SlowNoise | None:
    """Slow noise in the residual as a cause; beside effects only if identified, and no form error of the first.

    With the largest number of effects accepted, a coloured residual may hold a further effect that was never tried.
    """
    problem = selection.end.problem
    if selection.after.clean or len(accepted) == problem.policy.most_effects:
        return None
    noise = find_slow_noise(problem, selection.end.residual())
    if noise is None or not noise.fits:
        return None
    form = accepted and (not noise.identified or is_form_error(selection, accepted[0]))
    return None if form else noise


def is_form_error(selection: Selection, first: AcceptedEffect) -> bool:
    """Whether the residual is small enough for a form error of the first effect."""
    return _excess_rms(selection) < selection.end.problem.policy.quarter * first.evidence.strength


def _excess_rms(selection: Selection) -> float:
    """Rms of the residual beyond the noise of a sample, in its units."""
    return float(np.sqrt(max((selection.end.residual() ** 2).mean() - 1, 0.0)))


def beyond_wander(iron: Sequence[AcceptedEffect], selection: Selection) -> tuple[AcceptedEffect, ...]:
    """Changes of the iron that a slow wander, found or stated by the model, does not make by moving the mean.

    Constants, and changes that the data do not distinguish from a constant, stay only where far larger than the wander.
    """
    most = selection.end.problem.policy.tenfold * _excess_rms(selection)

    def may_be_constant(change: AcceptedEffect) -> bool:
        return any(BY_NAME[name].traits.constant for name in (change.name, *change.alternatives))

    return tuple(change for change in iron if change.evidence.strength > most or not may_be_constant(change))
