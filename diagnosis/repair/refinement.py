"""Refinement of effect parameters through the simulator's chain, with standard deviations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calib.numerics.squares import SAME, Squares
from diagnosis.evidence.noise_model import NoiseModel
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.chain import chain_residual
from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.effects.base import Effect
from sim.effects.free_parameters import FreeParameters

ROUNDS, CHAINS = 60, 1200
"""Largest number of steps, and of chain runs, one for each number in every step.

The start is close, but a gradient and its origin follow a bent valley.
"""
IMPOSSIBLE = 1e3
"""Residual, in units of the noise, of numbers invalid in combination."""


@dataclass(frozen=True)
class RefinedEffects:
    """Refined effects and, for each, the standard deviations of parameter components by parameter name."""

    effects: tuple[Effect, ...]
    spread: tuple[dict[str, Array], ...]


def refine(
    problem: LinearProblem,
    new: Sequence[Effect],
    use: NDArray[np.bool_],
    inflation: float = 1.0,
    *,
    refit_iron: bool = True,
    noise: NoiseModel | None = None,
) -> RefinedEffects:
    """Fit the new effects' parameters by least squares on the samples `use` (n,); in vector mode only.

    refit_iron : refit hard and soft iron in every step; otherwise keep the model's iron. noise : the noise model of a
    coloured residual. White least squares would take a part of a random walk into the parameters.

    The prediction is the simulator's chain along the measured motion. Standard deviations follow from the Jacobian at
    the solution, times the root of `inflation` for coloured noise.
    """
    numbers = FreeParameters(tuple(new))
    start, scale = numbers.values, numbers.scale
    if problem.mode != "vector" or not len(start):
        return RefinedEffects(tuple(new), tuple({} for _ in new))

    def residual(x: Array) -> Array:
        try:
            effects = numbers.at(start + x * scale)
        except InputError:  # each number is within its bounds, but not all together
            return np.full(problem.target[use].size, IMPOSSIBLE)
        return chain_residual(problem, effects, use if refit_iron else None, noise)[use].ravel()

    squares = Squares(residual)
    best = squares.least(np.zeros(len(start)), min(ROUNDS, 1 + CHAINS // len(start)))
    gram = squares.gram(best)
    std = np.sqrt(variances(gram, problem.policy) * inflation) * scale
    x = without_open_part(best, gram, problem.policy)
    as_good = squares.half(x) <= squares.half(best) * (1 + SAME)
    return RefinedEffects(numbers.at(start + (x if as_good else best) * scale), numbers.spread(std))


def without_open_part(x: Array, gram: Array, policy: Policy) -> Array:
    """Project undetermined directions out of a change x (k,), where a step is rounding error over nothing."""
    size, values, vectors = _correlation(gram)
    undetermined = vectors[:, values < policy.open_eigenvalue]
    return np.asarray(x - undetermined @ (undetermined.T @ (x * size)) / size)


def variances(gram: Array, policy: Policy) -> Array:
    """Diagonal (k,) of the inverse of a Gram matrix (k, k); infinite along undetermined directions."""
    size, values, vectors = _correlation(gram)
    undetermined = values < policy.open_eigenvalue
    known = (vectors[:, ~undetermined] ** 2 / values[~undetermined]).sum(axis=1) / size**2
    return np.where((vectors[:, undetermined] ** 2).sum(axis=1) > policy.open_part, np.inf, known)


def _correlation(gram: Array) -> tuple[Array, Array, Array]:
    """Sizes (k,) of the parameters, eigenvalues (k,) and eigenvectors (k, k) of their correlation."""
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    values, vectors = np.linalg.eigh(gram / np.outer(size, size))
    return size, values, vectors
