"""An effect that the model states wrongly in a parameter that no added effect can mend, as a lag: found anew."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from diagnosis.decision.joint_iron import select_jointly
from diagnosis.decision.selection import Progress, Selection, effect_names
from diagnosis.problem.formulation import pose_again
from diagnosis.problem.linear import LinearProblem, ReferenceCorrection
from sim.effects.base import Effect


def correct_stated_effects(selection: Selection, say: Progress = lambda what: None) -> Selection:
    """Select again without one of the model's effects, where what is left is then clean and the effect is found anew.

    A second effect of the same name mends a gain, since gains add; it does not mend a lag, a place or a threshold.
    Unchanged where the residual is clean, and for effects of iron, noise and the converter.
    """
    problem = selection.end.problem
    if selection.after.clean or not problem.turns:
        return selection
    for effect in _replaceable(problem):
        say(f"the model without its {effect.name}")
        again = select_jointly(_without(problem, effect), selection.without, say)
        if again.after.clean and effect.name in effect_names(again.accepted):
            return again
    return selection


def _replaceable(problem: LinearProblem) -> Iterator[Effect]:
    for effect in problem.effects:
        settled = effect.traits.absorbed or effect.traits.converter or effect.stochastic
        if not settled and effect.linear and set(effect.names()) - set(effect.linear):
            yield effect


def _without(problem: LinearProblem, effect: Effect) -> LinearProblem:
    """The problem of the model without one of its effects."""
    rest = tuple(other for other in problem.effects if other is not effect)
    words = f"The model's {effect.name} does not fit with any gain; it was left out and looked for anew."
    figures = f"Take the {effect.name} of the new model instead of the given one: not its size alone is wrong."
    done = ReferenceCorrection(words, figures)
    without = replace(problem, effects=rest, left_out=(*problem.left_out, effect))
    return pose_again(without, problem.recording, problem.state.field_enu_nT, done)
