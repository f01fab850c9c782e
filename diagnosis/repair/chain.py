"""The simulator's chain along the measured motion, with and without new effects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.vehicle_iron import fitted_iron
from scenarios.arrays import Array
from sim.chain import apply_deterministic
from sim.effects.base import Effect
from sim.effects.chain_position import insert_effects


def predict(problem: LinearProblem, new: Sequence[Effect]) -> Array:
    """Predict the field (n, 3) by the simulator's chain with new effects along the measured motion.

    Unknown iron is replaced by the fitted base. The converter is left out: rounding and clipping have no slope.
    """
    smooth = [effect for effect in insert_effects(_with_iron(problem), new) if not effect.traits.converter]
    return apply_deterministic(smooth, problem.state)[0]


def _with_iron(problem: LinearProblem) -> Sequence[Effect]:
    """The model's effects, with the iron of the fitted base where the model's is unknown."""
    return problem.effects if problem.iron_known else insert_effects(problem.effects, fitted_iron(problem))


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
    iron = [effect for effect in _with_iron(problem) if effect.traits.absorbed]
    passed_nT, _ = apply_deterministic(insert_effects(iron, new), problem.state)
    return np.column_stack([passed_nT / np.linalg.norm(problem.state.field_enu_nT), np.ones(len(passed_nT))])


def _passes_iron(effect: Effect) -> bool:
    return effect.stage == "field" or (effect.continuous and effect.stage == "sensor")


def residual_with_model_iron(problem: LinearProblem, new: Sequence[Effect]) -> Array:
    """Measured minus predicted (n, 3) in units of the noise, with the iron of the model."""
    return _residual(problem, predict(problem, new))


def _residual(problem: LinearProblem, predicted_nT: Array) -> Array:
    difference = (problem.recording.mag_nT - predicted_nT) / problem.sigma_nT
    return np.asarray(difference * problem.usable[:, None])
