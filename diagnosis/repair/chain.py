"""The simulator's chain along the measured motion, with and without new effects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from diagnosis.evidence.noise_model import NoiseModel
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


def residual_with_iron_refitted(
    problem: LinearProblem, new: Sequence[Effect], train: NDArray[np.bool_], noise: NoiseModel | None = None
) -> Array:
    """Measured minus predicted (n, 3) in units of the noise, with iron refitted next to new effects on `train` (n,).

    Contributions added behind the iron are not turned by a correction of it; fields that pass the iron are. noise : of
    a coloured residual, under which iron is refitted and the residual whitened; 0 outside `train`.
    """
    predicted_nT, base = predict(problem, new), _base(problem, [effect for effect in new if _passes_iron(effect)])
    if noise is not None:
        return _without_base(*_whitened(problem, problem.recording.mag_nT - predicted_nT, train, noise, base))
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


def residual_with_model_iron(problem: LinearProblem, new: Sequence[Effect], noise: NoiseModel | None = None) -> Array:
    """Measured minus predicted (n, 3) in units of the noise, with the iron of the model; whitened where it is coloured.

    noise : of a coloured residual.
    """
    predicted_nT = predict(problem, new)
    if noise is None:
        return _residual(problem, predicted_nT)
    every = np.ones(len(predicted_nT), np.bool_)
    return _whitened(problem, problem.recording.mag_nT - predicted_nT, every, noise)[0]


def _whitened(
    problem: LinearProblem, off_nT: Array, train: NDArray[np.bool_], noise: NoiseModel, base: Array | None = None
) -> tuple[Array, Array]:
    """Whitened residual (n, 3) and base (n, 3, p) of each axis, 0 where not used."""
    used = train * problem.usable
    each = np.zeros((len(off_nT), 3, 0)) if base is None else np.repeat(base[:, None], 3, axis=1)
    columns = np.concatenate([(off_nT / problem.sigma_nT)[:, :, None], each], axis=2) * used[:, None, None]
    z, _ = noise.whitened(problem.state.time_s, used, columns)
    return z[:, :, 0], z[:, :, 1:]


def _without_base(residual: Array, base: Array) -> Array:
    """A residual (n, 3) with a base (n, 3, p) of each axis fitted."""
    fitted = [
        B @ np.linalg.lstsq(B.T @ B, B.T @ y, rcond=1e-13)[0]
        for y, B in zip(residual.T, base.swapaxes(0, 1), strict=True)
    ]
    return np.asarray(residual - np.column_stack(fitted))


def _residual(problem: LinearProblem, predicted_nT: Array) -> Array:
    difference = (problem.recording.mag_nT - predicted_nT) / problem.sigma_nT
    return np.asarray(difference * problem.usable[:, None])
