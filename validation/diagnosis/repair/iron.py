"""Hard and soft iron of a problem whose model has none of its own: as the base has it."""

from __future__ import annotations

import numpy as np

from sim.effects.base import Effect
from sim.effects.iron import HardIron, SoftIron
from sim.state import Array
from validation.diagnosis.problem.linear import LinearProblem


def fitted_iron(problem: LinearProblem) -> tuple[Effect, Effect]:
    """Soft and hard iron, ahead of the model's axes, by which the base makes the measured field of the undisturbed one.

    Brought into their bounds: a motion that hardly shows a direction may leave it beyond.
    """
    back = np.linalg.inv(problem.turn_behind(SoftIron))
    offset_nT = problem.clean_nT.mean(axis=0) - problem.turn @ problem.state.field_nT.mean(axis=0)
    return _possible(SoftIron, back @ problem.turn - np.eye(3)), _possible(HardIron, back @ offset_nT)


def _possible(iron: type[SoftIron] | type[HardIron], values: Array) -> Effect:
    parameter = iron.parameters()[0]
    return iron(**{parameter.name: np.clip(values, parameter.low, parameter.high).tolist()})
