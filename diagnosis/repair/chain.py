"""The simulator's chain along the measured motion, with and without new effects, and iron fitted beside them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.evidence.noise_model import NoiseModel
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.model_effects import fitted_iron
from diagnosis.problem.strength import strength_problem
from diagnosis.problem.vector import fit_matrix, robust_fit
from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.chain import apply_deterministic
from sim.effects.base import Effect
from sim.effects.chain_position import insert_effects

STEPS = 3
"""Number of iron fits: each leaves the effects on the earth's field times the error of the previous iron."""


def predict(problem: LinearProblem, new: Sequence[Effect]) -> Array:
    """Predict the field (n, 3) by the simulator's chain with new effects along the measured motion.

    Unknown iron is replaced by the fitted base. The converter is left out: rounding and clipping have no slope.
    """
    smooth = [effect for effect in insert_effects(with_iron(problem), new) if not effect.traits.converter]
    return apply_deterministic(smooth, problem.state)[0]


def with_iron(problem: LinearProblem) -> tuple[Effect, ...]:
    """The model's effects, with the iron of the fitted base where the model's is unknown."""
    return problem.effects if problem.iron_known else insert_effects(problem.effects, fitted_iron(problem))


def chain_residual(
    problem: LinearProblem,
    new: Sequence[Effect],
    train: NDArray[np.bool_] | None = None,
    noise: NoiseModel | None = None,
) -> Array:
    """Measured minus predicted (n, 3) with new effects, in units of the noise.

    train : samples (n,) on which iron is refitted next to the new effects; None: the iron stays as it is. noise : of a
    coloured residual, under which iron is refitted and the residual whitened; the residual is then 0 outside `train`.
    """
    off = (problem.recording.mag_nT - predict(problem, new)) / problem.sigma_nT
    used = problem.usable if train is None else train * problem.usable
    base = off[:, :0] if train is None else _base(problem, new)
    if noise is None:
        fitted = base @ _solved(base * used[:, None], base, off) if base.size else 0.0
        return np.asarray((off - fitted) * problem.usable[:, None])
    each = np.concatenate([off[:, :, None], np.repeat(base[:, None], 3, axis=1)], axis=2) * used[:, None, None]
    z = noise.whitened(problem.state.time_s, used, each)[0].swapaxes(0, 1)
    return np.column_stack([axis[:, 0] - axis[:, 1:] @ _solved(axis[:, 1:], axis[:, 1:], axis[:, 0]) for axis in z])


def _solved(weighted: Array, base: Array, off: Array) -> Array:
    """Coefficients of a base (n, p) for a residual (n,) or (n, q), by the weighted base (n, p)."""
    return np.asarray(np.linalg.lstsq(weighted.T @ base, weighted.T @ off, rcond=1e-13)[0]) if base.size else off[:0]


def _base(problem: LinearProblem, new: Sequence[Effect]) -> Array:
    """The base (n, p) of a field changed by new effects that pass the iron, which a correction of the iron turns."""
    passing = [effect for effect in new if effect.stage == "field" or (effect.continuous and effect.stage == "sensor")]
    if problem.still or not passing:
        return problem.base
    iron = [effect for effect in with_iron(problem) if effect.traits.absorbed]
    passed_nT, _ = apply_deterministic(insert_effects(iron, passing), problem.state)
    return np.column_stack([passed_nT / np.linalg.norm(problem.state.field_enu_nT), np.ones(len(passed_nT))])


def fit_iron_with_effects(problem: LinearProblem, effects: Sequence[Effect]) -> LinearProblem:
    """Fit iron with the effects' contributions subtracted, on samples outside their windows if sufficient.

    Unchanged where the model's iron is known.
    """
    acting = [effect.is_active(problem.state.time_s) for effect in effects if effect.active_s is not None]
    use = ~np.logical_or.reduce([problem.usable == 0, *acting])
    vector = problem.mode == "vector"
    as_it_is = not vector and all(effect.stochastic for effect in effects)
    if problem.iron_known or as_it_is or use.sum() < problem.policy.least_samples:
        return problem
    anew = problem
    for _ in range(STEPS if vector else 1):  # no effect on the earth's field is known without attitude
        known = replace(problem, effects=with_iron(anew), iron_known=True)
        added_nT = predict(known, effects) - predict(known, ())
        try:
            anew = _with_iron_fitted(problem, problem.recording.mag_nT - added_nT, use)
        except InputError:
            break
    return anew


def _with_iron_fitted(problem: LinearProblem, mag_nT: Array, use: NDArray[np.bool_]) -> LinearProblem:
    """The problem with iron fitted to the samples `use` (n,) of a measured field (n, 3)."""
    if problem.mode == "vector":
        field_nT, base = problem.state.field_nT, problem.base[use]
        clean_nT = base @ robust_fit(base, (mag_nT - problem.beyond_nT)[use], problem.policy)
        turn = problem.turn if problem.still else fit_matrix(field_nT[use], clean_nT)
        offset_nT = clean_nT.mean(axis=0) - turn @ field_nT[use].mean(axis=0)
        return replace(problem, turn=turn, clean_nT=field_nT @ turn.T + offset_nT + problem.beyond_nT)
    seen = replace(problem.recording, mag_nT=mag_nT).taken(use)
    track = None if problem.track is None else problem.track.at(use)
    level = None if problem.level is None else problem.level.at(use)
    strength_nT = float(np.linalg.norm(problem.state.field_enu_nT))
    return strength_problem(seen, strength_nT, problem.effects, problem.policy, track=track, level=level)
