"""The simulator's own chain along the measured motion, with and without new effects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.chain import apply_deterministic
from sim.effects.base import Effect
from sim.effects.chain_position import insert_effects
from sim.effects.iron import HardIron, SoftIron


def predict(problem: LinearProblem, new: Sequence[Effect]) -> Array:
    """What the simulator's chain with the new effects gives along the measured motion (n, 3).

    Where the iron is not known they are beside that of the base. What the converter does to each value is left out:
    rounding and clipping have no slope.
    """
    given = problem.effects if problem.iron_known else insert_effects(problem.effects, fitted_iron(problem))
    smooth = [effect for effect in insert_effects(given, new) if not effect.traits.converter]
    return apply_deterministic(smooth, problem.state)[0]


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


def left_with_iron_refitted(problem: LinearProblem, new: Sequence[Effect], train: NDArray[np.bool_]) -> Array:
    """Measured minus predicted (n, 3) in units of the noise, hard and soft iron fitted beside new effects on `train`.

    What these add behind the iron is not turned by a correction of it, which passes what follows the field's course.
    """
    predicted_nT, base = predict(problem, new), _base(problem, [one for one in new if _is_passed(one)])
    used = base * (train * problem.usable)[:, None]
    off_nT = problem.recording.mag_nT - predicted_nT
    beta = np.linalg.lstsq(used.T @ base, used.T @ off_nT, rcond=1e-13)[0]
    return _left(problem, predicted_nT + base @ beta)


def _base(problem: LinearProblem, new: Sequence[Effect]) -> Array:
    """The base (n, p) of a field that new effects change before and behind the iron."""
    if problem.still or not new:
        return problem.base
    predicted_nT = predict(problem, new)
    return np.column_stack([predicted_nT / np.linalg.norm(problem.state.field_enu_nT), np.ones(len(predicted_nT))])


def _is_passed(effect: Effect) -> bool:
    return effect.stage == "field" or (effect.continuous and effect.stage == "sensor")


def left_as_it_stands(problem: LinearProblem, new: Sequence[Effect]) -> Array:
    """Measured minus predicted (n, 3) in units of the noise, the iron as the model has it."""
    return _left(problem, predict(problem, new))


def _left(problem: LinearProblem, predicted_nT: Array) -> Array:
    left = (problem.recording.mag_nT - predicted_nT) / problem.sigma_nT
    return np.asarray(left * problem.usable[:, None])
