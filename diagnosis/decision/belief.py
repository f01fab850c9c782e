"""What is believed of a selection, after doubts: effects, changes of the iron, slow noise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.decision.iron import iron_changes
from diagnosis.decision.selection import Selection
from diagnosis.decision.white_choice import Accepted
from diagnosis.evidence.model_noise import states_wander
from diagnosis.evidence.residual_tests import ResidualTests
from diagnosis.evidence.slow_noise import SlowNoise, wander
from sim.effects import BY_NAME


@dataclass(frozen=True)
class Belief:
    """Effects found, changes of the iron and slow noise that are believed.

    counted: changes of the iron that belong to what an effect is counted from, and are no findings.
    """

    selection: Selection
    found: tuple[Accepted, ...]
    iron: tuple[Accepted, ...] = ()
    counted: tuple[Accepted, ...] = ()
    noise: SlowNoise | None = None

    @property
    def clean(self) -> bool:
        """Whether nothing is left without a cause."""
        return self.after.clean or self.noise is not None

    @property
    def after(self) -> ResidualTests:
        """The tests of what the believed effects leave."""
        selection = self.selection
        return selection.after if self.found or not selection.found else selection.before


Doubt = Callable[[Belief], Belief]


def believed(selection: Selection) -> Belief:
    """What of a selection stands after every doubt of `DOUBTS`, in their order; the main cause comes first."""
    main_first = sorted(selection.found, key=lambda one: (one.form_of is not None, -one.evidence.strength))
    belief = Belief(selection, tuple(main_first))
    for doubt in DOUBTS:
        belief = doubt(belief)
    return belief


def slow_noise_is_left(belief: Belief) -> Belief:
    """Slow noise in what the effects leave is one of its own, unless it is as small as the first effect's form.

    Beside as many effects as are looked for nobody has asked whether what is left is another.
    """
    selection = belief.selection
    if selection.after.clean or len(selection.found) == selection.end.problem.policy.most_effects:
        return belief
    noise = wander(selection.end.problem, selection.end.residual())
    if noise is None or not noise.fits or (belief.found and not noise.identified):
        return belief
    return belief if belief.found and _is_form(belief) else replace(belief, noise=noise)


def _is_form(belief: Belief) -> bool:
    policy = belief.selection.end.problem.policy
    return _excess(belief) < policy.form_noise * belief.found[0].evidence.strength


def _excess(belief: Belief) -> float:
    """Rms of what the effects leave beyond the noise of a sample, in its units."""
    return float(np.sqrt(max((belief.selection.end.residual() ** 2).mean() - 1, 0.0)))


def iron_differs(belief: Belief) -> Belief:
    """Where the model's iron is known, what differs from it is a finding too."""
    if not belief.selection.end.problem.iron_known:
        return belief
    changes = iron_changes(belief.selection)
    return replace(belief, iron=changes.found, counted=changes.counted)


def wander_moves_the_mean(belief: Belief) -> Belief:
    """A slow wander changes the mean: beside one that was found, or that the model states, no constant has changed.

    Nor has what the data do not tell from a constant; but for one that is far larger than the wander.
    """
    problem = belief.selection.end.problem
    if belief.noise is None and not states_wander(problem):
        return belief
    most = problem.policy.wander_moves * _excess(belief)
    kept = (one for one in belief.iron if one.evidence.strength > most or not _may_be_constant(one))
    return replace(belief, iron=tuple(kept))


def _may_be_constant(one: Accepted) -> bool:
    return any(BY_NAME[name].traits.constant for name in (one.name, *one.alternatives))


DOUBTS: tuple[Doubt, ...] = (slow_noise_is_left, iron_differs, wander_moves_the_mean)
