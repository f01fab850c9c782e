"""Hard and soft iron of a problem whose model has none of its own: as the base has it."""

from __future__ import annotations

import numpy as np

from sim.effects.base import Effect
from sim.effects.iron import HardIron, SoftIron
from sim.state import Array
from validation.diagnosis.problem.linear import LinearProblem

Iron = tuple[Effect, Effect]


def fitted_iron(problem: LinearProblem) -> Iron:
    """Soft and hard iron by which the base makes the measured field of the undisturbed one."""
    return iron_between(problem.state.field_nT, problem.clean_nT, problem.turn)


def iron_between(field_nT: Array, measured_nT: Array, turn: Array) -> Iron:
    """Soft and hard iron that make a measured field (n, 3) of another by a matrix (3, 3), and a constant in the mean.

    Brought into their bounds: a motion that hardly shows a direction may leave it beyond.
    """
    offset_nT = measured_nT.mean(axis=0) - turn @ field_nT.mean(axis=0)
    return _possible(SoftIron, turn - np.eye(3)), _possible(HardIron, offset_nT)


def _possible(iron: type[SoftIron] | type[HardIron], values: Array) -> Effect:
    parameter = iron.parameters()[0]
    return iron(**{parameter.name: np.clip(values, parameter.low, parameter.high).tolist()})
