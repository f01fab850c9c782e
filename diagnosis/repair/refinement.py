"""Refinement through the simulator's chain along the measured motion: parameters of effects, and iron beside them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calib.numerics.squares import DIFFERENCE, SAME, Squares
from diagnosis.evidence.hypothesis import project_out
from diagnosis.evidence.noise_model import NoiseModel
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


def chain_residual(problem: LinearProblem, new: Sequence[Effect], train: NDArray[np.bool_] | None = None) -> Array:
    """Measured minus predicted (n, 3) with new effects, in units of the noise.

    train : samples (n,) on which iron is refitted next to the new effects; None: the iron stays as it is.
    """
    off = (problem.recording.mag_nT - predict(problem, new)) / problem.sigma_nT
    if train is not None:
        base = _base(problem, new)
        weighted = (base * (train * problem.usable)[:, None]).T
        off -= base @ np.linalg.lstsq(weighted @ base, weighted @ off, rcond=1e-13)[0]
    return np.asarray(off * problem.usable[:, None])


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

    squares = Squares(_Residual(problem, numbers, use, noise, refit_iron))
    best = squares.least(np.zeros(len(start)), min(ROUNDS, 1 + CHAINS // len(start)))
    variances, onto_determined = determined(squares.gram(best), problem.policy)
    x = onto_determined @ best
    as_good = squares.half(x) <= squares.half(best) * (1 + SAME)
    std = np.sqrt(variances * inflation) * scale
    return numbers.at(start + (x if as_good else best) * scale), numbers.spread(std)


@dataclass
class _Residual:
    """Residual of numbers of new effects on the samples `use` (n,), in units of the noise and without its colour.

    Beside refitted iron: its base, whitened, is kept for all slopes at one point.
    """

    problem: LinearProblem
    numbers: FreeParameters
    use: NDArray[np.bool_]
    noise: NoiseModel | None
    refit_iron: bool
    _base: tuple[Array, Array] | None = None

    def __call__(self, x: Array) -> Array:
        """Residual at changes x (k,) of the numbers, over their scales."""
        problem = self.problem
        try:
            effects = self.numbers.at(self.numbers.values + x * self.numbers.scale)
        except InputError:  # each number is within its bounds, but not all together
            return np.full(problem.target[self.use].size, IMPOSSIBLE)
        off = self._whitened(((problem.recording.mag_nT - predict(problem, effects)) / problem.sigma_nT)[:, :, None])
        if self.refit_iron:
            if self._base is None or np.abs(x - self._base[0]).max() > 2 * DIFFERENCE:
                self._base = x.copy(), self._whitened(np.repeat(_base(problem, effects)[:, None], 3, axis=1))
            off, _ = project_out(self._base[1], off, common=False)
        return off[self.use].ravel()

    def _whitened(self, columns: Array) -> Array:
        used = self.use * self.problem.usable
        columns = columns * used[:, None, None]
        return columns if self.noise is None else self.noise.whitened(self.problem.state.time_s, used, columns)[0]


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
