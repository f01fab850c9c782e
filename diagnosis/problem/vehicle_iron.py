"""Hard and soft iron of the vehicle that turn the model's iron into the fitted base."""

from __future__ import annotations

from typing import Any

import numpy as np

from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.chain import apply_deterministic
from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.effects.chain_position import chain_position, insert_effects, iron_matrix

_ABSORBED = [effect for effect in EFFECTS if effect.traits.absorbed and effect.stage == "vehicle"]
SOFT, HARD = sorted(_ABSORBED, key=lambda effect: effect.traits.constant)
"""Iron of the vehicle: a matrix, and a constant."""


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
