"""The simulator's chain along the measured motion, with and without new effects."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.chain import apply_deterministic
from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.effects.chain_position import insert_effects

_ABSORBED = [effect for effect in EFFECTS if effect.traits.absorbed and effect.stage == "vehicle"]
SOFT, HARD = sorted(_ABSORBED, key=lambda effect: effect.traits.constant)
"""Iron of the vehicle: a matrix, and a constant."""


def predict(problem: LinearProblem, new: Sequence[Effect]) -> Array:
    """Predict the field (n, 3) by the simulator's chain with new effects along the measured motion.

    Unknown iron is replaced by the fitted base. The converter is left out: rounding and clipping have no slope.
    """
    given = problem.effects if problem.iron_known else insert_effects(problem.effects, fitted_iron(problem))
    smooth = [effect for effect in insert_effects(given, new) if not effect.traits.converter]
    return apply_deterministic(smooth, problem.state)[0]


def fitted_iron(problem: LinearProblem) -> tuple[Effect, Effect]:
    """Soft and hard iron, ahead of the model's axes, equivalent to the fitted base.

    Clipped to their bounds, which a direction hardly shown by the motion may exceed.
    """
    back = np.linalg.inv(problem.matrix_behind(SOFT))
    offset_nT = problem.clean_nT.mean(axis=0) - problem.turn @ problem.state.field_nT.mean(axis=0)
    return _within_bounds(SOFT, back @ problem.turn - np.eye(3)), _within_bounds(HARD, back @ offset_nT)


def _within_bounds(iron: type[Effect], values: Array) -> Effect:
    parameter = iron.parameters()[0]
    value: Any = np.clip(values, parameter.low, parameter.high).tolist()
    return iron(**{parameter.name: value})


def residual_with_iron_refitted(problem: LinearProblem, new: Sequence[Effect], train: NDArray[np.bool_]) -> Array:
    """Measured minus predicted (n, 3) in units of the noise, with iron refitted next to new effects on `train` (n,).

    Contributions added behind the iron are not turned by a correction of it; fields that pass the iron are.
    """
    predicted_nT, base = predict(problem, new), _base(problem, [effect for effect in new if _passes_iron(effect)])
    used = base * (train * problem.usable)[:, None]
    off_nT = problem.recording.mag_nT - predicted_nT
    beta = np.linalg.lstsq(used.T @ base, used.T @ off_nT, rcond=1e-13)[0]
    return _residual(problem, predicted_nT + base @ beta)


def _base(problem: LinearProblem, new: Sequence[Effect]) -> Array:
    """The base (n, p) of a field changed by new effects before and behind the iron."""
    if problem.still or not new:
        return problem.base
    predicted_nT = predict(problem, new)
    return np.column_stack([predicted_nT / np.linalg.norm(problem.state.field_enu_nT), np.ones(len(predicted_nT))])


def _passes_iron(effect: Effect) -> bool:
    return effect.stage == "field" or (effect.continuous and effect.stage == "sensor")


def residual_with_model_iron(problem: LinearProblem, new: Sequence[Effect]) -> Array:
    """Measured minus predicted (n, 3) in units of the noise, with the iron of the model."""
    return _residual(problem, predict(problem, new))


def _residual(problem: LinearProblem, predicted_nT: Array) -> Array:
    difference = (problem.recording.mag_nT - predicted_nT) / problem.sigma_nT
    return np.asarray(difference * problem.usable[:, None])
