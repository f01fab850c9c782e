"""Position of an effect in a given chain, and the transformation of a contribution by the effects behind."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scenarios.arrays import Array
from sim.effects import BY_NAME
from sim.effects.base import Effect
from sim.state import State

RANK = {name: i for i, name in enumerate(BY_NAME)}
"""Name of an effect -> physical place among all effects."""


def chain_position(given: Sequence[Effect], name: str) -> int:
    """Position of a new effect: behind effects of the same name, else before the first with a later physical place."""
    same = [i for i, other in enumerate(given) if other.name == name]
    if same:
        return same[-1] + 1
    return next((i for i, other in enumerate(given) if RANK[other.name] > RANK[name]), len(given))


def insert_effects(given: Sequence[Effect], new: Sequence[Effect]) -> tuple[Effect, ...]:
    """The given effects in the given order, with new ones inserted at their physical place."""
    out = list(given)
    for effect in new:
        out.insert(chain_position(out, effect.name), effect)
    return tuple(out)


def without_iron(effects: Sequence[Effect]) -> tuple[Effect, ...]:
    """The effects without hard iron, soft iron and constant offsets."""
    return tuple(
        one for one in effects if not (one.traits.constant or (one.traits.absorbed and one.stage == "vehicle"))
    )


def iron_matrix(effects: Sequence[Effect], state: State) -> Array:
    """Matrix (3, 3) of the soft iron, axes and scale among the effects of a chain."""
    axes = np.eye(3)
    for other in effects:
        if other.traits.absorbed and not other.traits.constant:
            axes = axes + other.apply(state, axes, np.random.default_rng(0), {})
    return axes.T
