"""Refinement through the simulator's chain along the measured motion: parameters of effects, and iron beside them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from calib.numerics.squares import SAME, Squares
from diagnosis.evidence.noise_model import NoiseModel
from diagnosis.evidence.projections import project_out
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.strength import strength_problem
from diagnosis.problem.vector import fit_matrix, robust_fit
from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.chain import apply_deterministic
from sim.effects.base import Effect
from sim.effects.chain_position import insert_effects
from sim.effects.free_parameters import FreeParameters

STEPS = 3
"""Number of iron fits: each leaves the effects on the earth's field times the error of the previous iron."""
ROUNDS, CHAINS = 60, 1200
"""Largest number of steps, and of chain runs, one for each number in every step.

The start is close, but a gradient and its origin follow a bent valley.
"""
IMPOSSIBLE = 1e3
"""Residual, in units of the noise, of numbers invalid in combination."""


def predict(problem: LinearProblem, new: Sequence[Effect]) -> Array:
    """Predict the field (n, 3) by the simulator's chain with new effects along the measured motion.

    Unknown iron is replaced by the fitted base. The converter is left out: rounding and clipping have no slope.
    """
    smooth = [effect for effect in insert_effects(_with_iron(problem), new) if not effect.traits.converter]
    return apply_deterministic(smooth, problem.state)[0]


def _with_iron(problem: LinearProblem) -> tuple[Effect, ...]:
    return problem.effects if problem.iron_known else insert_effects(problem.effects, problem.fitted_iron)


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
        weighted = (base * used[:, None]).T
        fitted = base @ np.linalg.lstsq(weighted @ base, weighted @ off, rcond=1e-13)[0]
        return np.asarray((off - fitted) * problem.usable[:, None])
    each = np.concatenate([off[:, :, None], np.repeat(base[:, None], 3, axis=1)], axis=2) * used[:, None, None]
    white = noise.whitened(problem.state.time_s, used, each)[0]
    return project_out(white[:, :, 1:], white[:, :, :1], common=False)[0][:, :, 0]


def _base(problem: LinearProblem, new: Sequence[Effect]) -> Array:
    """The base (n, p) of a field changed by new effects that pass the iron, which a correction of the iron turns."""
    passing = [effect for effect in new if effect.stage == "field" or (effect.continuous and effect.stage == "sensor")]
    if problem.still or not passing:
        return problem.base
    iron = [effect for effect in _with_iron(problem) if effect.traits.absorbed]
    passed_nT, _ = apply_deterministic(insert_effects(iron, passing), problem.state)
    return np.column_stack([passed_nT / np.linalg.norm(problem.state.field_enu_nT), np.ones(len(passed_nT))])


def refine(
    problem: LinearProblem,
    new: Sequence[Effect],
    use: NDArray[np.bool_],
    inflation: float = 1.0,
    *,
    refit_iron: bool = True,
    noise: NoiseModel | None = None,
) -> tuple[tuple[Effect, ...], tuple[dict[str, Array], ...]]:
    """Fit the new effects by least squares on the samples `use` (n,), with standard deviations by parameter name.

    The prediction is the simulator's chain along the measured motion, in vector mode only. Standard deviations follow
    from the Jacobian at the solution, times the root of `inflation` for coloured noise.

    refit_iron : refit hard and soft iron in every step; otherwise keep the model's iron. noise : the noise model of a
    coloured residual. White least squares would take a part of a random walk into the parameters.
    """
    numbers = FreeParameters(tuple(new))
    start, scale = numbers.values, numbers.scale
    if problem.mode != "vector" or not len(start):
        return tuple(new), tuple({} for _ in new)

    def residual(x: Array) -> Array:
        try:
            effects = numbers.at(start + x * scale)
        except InputError:  # each number is within its bounds, but not all together
            return np.full(problem.target[use].size, IMPOSSIBLE)
        return chain_residual(problem, effects, use if refit_iron else None, noise)[use].ravel()

    squares = Squares(residual)
    best = squares.least(np.zeros(len(start)), min(ROUNDS, 1 + CHAINS // len(start)))
    variances, onto_determined = determined(squares.gram(best), problem.policy)
    x = onto_determined @ best
    as_good = squares.half(x) <= squares.half(best) * (1 + SAME)
    std = np.sqrt(variances * inflation) * scale
    return numbers.at(start + (x if as_good else best) * scale), numbers.spread(std)


def determined(gram: Array, policy: Policy) -> tuple[Array, Array]:
    """Variances (k,) of parameters by their Gram matrix (k, k), and the projection (k, k) onto determined changes.

    Variances are the diagonal of the inverse, and infinite along undetermined directions, where a change is rounding
    error over nothing.
    """
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    values, vectors = np.linalg.eigh(gram / np.outer(size, size))
    known = values >= policy.open_eigenvalue
    inside, outside = vectors[:, known], vectors[:, ~known]
    variances = (inside**2 / values[known]).sum(axis=1) / size**2
    projection = np.eye(len(size)) - (outside @ outside.T) * size / size[:, None]
    return np.where((outside**2).sum(axis=1) > policy.open_part, np.inf, variances), projection


def fit_iron_with_effects(problem: LinearProblem, effects: Sequence[Effect]) -> LinearProblem:
    """Fit unknown iron with the effects' contributions subtracted, on samples outside their windows if sufficient."""
    acting = [effect.is_active(problem.state.time_s) for effect in effects if effect.active_s is not None]
    use = ~np.logical_or.reduce([problem.usable == 0, *acting])
    vector = problem.mode == "vector"
    as_it_is = not vector and all(effect.stochastic for effect in effects)
    if problem.iron_known or as_it_is or use.sum() < problem.policy.least_samples:
        return problem
    anew = problem
    for _ in range(STEPS if vector else 1):  # no effect on the earth's field is known without attitude
        known = replace(problem, effects=_with_iron(anew), iron_known=True)
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
    return strength_problem(seen, problem.known.at(use))
