"""Effects of the given model beside the fitted iron: what they add, and the iron in their chain that equals the fit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.chain import apply_deterministic
from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.effects.chain_position import chain_position, insert_effects, iron_matrix
from sim.state import State

STEPS = 4
"""Steps between the fitted iron and the model's effects behind it: each squares the error of the preceding step."""
SOFT, HARD = sorted(
    (effect for effect in EFFECTS if effect.traits.absorbed and effect.stage == "vehicle"),
    key=lambda effect: effect.traits.constant,
)
"""Iron of the vehicle: a matrix, and a constant."""


def about_model_effects(pose: Callable[[Array | float], LinearProblem]) -> LinearProblem:
    """The problem about what the model's effects beyond iron add (n, 3), each behind the fitted iron.

    Effects without recorded inputs, random effects and effects of the converter are left out.
    """
    problem = pose(0.0)
    known = [each for each in problem.effects if not (problem.missing_inputs(each) or each.traits.converter)]
    beyond_iron = any(not effect.traits.absorbed and not effect.stochastic for effect in known)
    for _ in range(STEPS if beyond_iron else 0):
        problem = pose(beyond_iron_nT(insert_effects(known, fitted_iron(problem)), problem.state))
    return problem


def beyond_iron_nT(effects: Sequence[Effect], state: State) -> Array:
    """Contribution (n, 3) of a chain of effects less the contribution of its iron alone."""
    iron = [effect for effect in effects if effect.traits.absorbed]
    return apply_deterministic(effects, state)[0] - apply_deterministic(iron, state)[0]


def fitted_iron(problem: LinearProblem) -> tuple[Effect, Effect]:
    """Soft and hard iron that, inserted into the model's chain, make its iron equivalent to the fitted base.

    ``turn = B (I + S) A`` with the model's axes A ahead of the soft iron S and B behind. Clipped to their bounds, which
    a direction hardly shown by the motion may exceed.
    """
    place = chain_position(problem.effects, SOFT.name)
    ahead, behind = (iron_matrix(part, problem.state) for part in (problem.effects[:place], problem.effects[place:]))
    soft = _within_bounds(SOFT, np.linalg.inv(behind) @ problem.turn @ np.linalg.inv(ahead) - np.eye(3))
    iron = insert_effects([effect for effect in problem.effects if effect.traits.absorbed], [soft])
    modelled_nT = apply_deterministic(iron, problem.state)[0].mean(axis=0)
    missing_nT = problem.offset_nT + problem.turn @ problem.state.field_nT.mean(axis=0) - modelled_nT
    return soft, _within_bounds(HARD, np.linalg.inv(problem.matrix_behind(HARD)) @ missing_nT)


def _within_bounds(iron: type[Effect], values: Array) -> Effect:
    parameter = iron.parameters()[0]
    value: Any = np.clip(values, parameter.low, parameter.high).tolist()
    return iron(**{parameter.name: value})
