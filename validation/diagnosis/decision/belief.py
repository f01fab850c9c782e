"""What is believed of a selection, after doubts: effects, changes of the iron, slow noise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from sim.effects import BY_NAME
from validation.diagnosis.decision.iron import iron_changes
from validation.diagnosis.decision.selection import Accepted, Selection
from validation.diagnosis.evidence.battery import Battery
from validation.diagnosis.evidence.slow_noise import SlowNoise, wander, white_score


@dataclass(frozen=True)
class Wanders:
    """Slow noise as it shows without the found effects, and beside them; score: of what they leave, taken as white."""

    alone: SlowNoise | None = None
    beside: SlowNoise | None = None
    score: float = 0.0

    @classmethod
    def of(cls, selection: Selection) -> Wanders:
        """The evidence of slow noise in a selection; none where nothing was found and nothing is left."""
        problem, left = selection.end.problem, selection.end.residual()
        if not selection.found:
            return cls() if selection.after.clean else cls(wander(problem, left))
        alone = wander(problem, selection.start.residual())
        beside = None if selection.after.clean else wander(problem, left)
        return cls(alone, beside, white_score(problem, left))


@dataclass(frozen=True)
class Belief:
    """Effects found, changes of the iron and slow noise that are believed; `unexplained`: too little is explained."""

    selection: Selection
    wanders: Wanders
    found: tuple[Accepted, ...]
    iron: tuple[Accepted, ...] = ()
    noise: SlowNoise | None = None
    unexplained: bool = False

    @property
    def clean(self) -> bool:
        """Whether nothing is left without a cause."""
        return self.after.clean or self.noise is not None

    @property
    def after(self) -> Battery:
        """The tests of what the believed effects leave."""
        selection = self.selection
        return selection.after if self.found or not selection.found else selection.before


Doubt = Callable[[Belief], Belief]


def believed(selection: Selection) -> Belief:
    """What of a selection stands after every doubt of `DOUBTS`, in their order."""
    belief = Belief(selection, Wanders.of(selection), selection.found)
    for doubt in DOUBTS:
        belief = doubt(belief)
    return belief


def noise_instead_of_effects(belief: Belief) -> Belief:
    """Slow noise alone has the name where it explains the gap as well as the found effects do."""
    alone = belief.wanders.alone
    if alone is None or not alone.fits:
        return belief
    if belief.found and _score_with_effects(belief) >= alone.score:
        return belief
    return replace(belief, found=(), noise=alone)


def noise_beside_effects(belief: Belief) -> Belief:
    """Slow noise in what the effects leave is one of its own, unless it is as small as the first effect's form."""
    beside = belief.wanders.beside
    if belief.noise is not None or beside is None or not (beside.fits and beside.identified):
        return belief
    left = belief.selection.end.residual()
    excess = float(np.sqrt(max((left**2).mean() - 1, 0.0)))
    form = belief.selection.end.problem.policy.form_noise * belief.found[0].evidence.strength
    return belief if excess < form else replace(belief, noise=beside)


def little_is_explained(belief: Belief) -> Belief:
    """Effects that leave structure and explain less than half of the gap are no names."""
    selection = belief.selection
    if belief.noise is not None or selection.after.clean:
        return belief
    if explained_share(selection) >= selection.end.problem.policy.half:
        return belief
    return replace(belief, found=(), unexplained=True)


def iron_differs(belief: Belief) -> Belief:
    """Where the model's iron is known, what differs from it is a finding too."""
    if belief.unexplained or not belief.selection.end.problem.iron_known:
        return belief
    return replace(belief, iron=iron_changes(belief.selection))


def wander_moves_the_mean(belief: Belief) -> Belief:
    """A slow wander changes the mean: beside it no constant has changed."""
    if belief.noise is None:
        return belief
    return replace(belief, iron=tuple(one for one in belief.iron if not BY_NAME[one.name].clues.constant))


DOUBTS: tuple[Doubt, ...] = (
    noise_instead_of_effects,
    noise_beside_effects,
    little_is_explained,
    iron_differs,
    wander_moves_the_mean,
)


def explained_share(selection: Selection) -> float:
    """Share of the gap that the found effects explain, on the data that they were fitted to; 1 if it is hardly one."""
    before, after = (float((ground.residual() ** 2).mean()) - 1 for ground in (selection.start, selection.end))
    return (before - after) / before if before > selection.end.problem.policy.least_excess else 1.0


def _score_with_effects(belief: Belief) -> float:
    """Log-likelihood of the steps with the effects in, less the price of their columns.

    With a wander beside them the price is higher: the best of many slow courses takes more from a noise than its
    columns would by chance.
    """
    selection, beside = belief.selection, belief.wanders.beside
    policy, columns = selection.end.problem.policy, int(selection.end.inside.shape[2])
    if beside is None or not beside.fits or beside.score <= belief.wanders.score:
        return belief.wanders.score - (columns + policy.apart)
    return beside.score - policy.course_price * (columns + policy.apart * len(selection.found))
