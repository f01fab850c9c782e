"""Parameters of named effects, refined through the simulator's own chain, with their standard deviations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calib.numerics.squares import SAME, Squares
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.chain import left_as_it_stands, left_with_iron_refitted
from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.effects.base import Effect
from sim.effects.free_parameters import FreeParameters

ROUNDS, CHAINS = 60, 1200
"""Steps at most: the start is close already, but a gradient and its origin are found along a bent valley; and runs of
the chain at most, one a number in every step."""
IMPOSSIBLE = 1e3
"""Residual, in units of the noise, of numbers that an effect does not take together."""


@dataclass(frozen=True)
class Refined:
    """Effects after refinement and, for each, name of a parameter -> standard deviation of its components."""

    effects: tuple[Effect, ...]
    spread: tuple[dict[str, Array], ...]


def refined(
    problem: LinearProblem,
    new: Sequence[Effect],
    use: NDArray[np.bool_],
    inflation: float = 1.0,
    *,
    refit_iron: bool = True,
) -> Refined:
    """Least squares of the new effects' parameters on the samples `use` (n,); in vector mode only.

    refit_iron : hard and soft iron are refitted at every step; otherwise they are the model's.

    The prediction is the simulator's chain along the measured motion; standard deviations from the Jacobian there,
    times the root of `inflation` for what is coloured.
    """
    numbers = FreeParameters(tuple(new))
    start, scale = numbers.values, numbers.scale
    if problem.mode != "vector" or not len(start):
        return Refined(tuple(new), tuple({} for _ in new))

    def residual(x: Array) -> Array:
        try:
            effects = numbers.at(start + x * scale)
        except InputError:  # each number is within its bounds, but not all together
            return np.full(problem.target[use].size, IMPOSSIBLE)
        left = left_with_iron_refitted(problem, effects, use) if refit_iron else left_as_it_stands(problem, effects)
        return left[use].ravel()

    squares = Squares(residual)
    best = squares.least(np.zeros(len(start)), min(ROUNDS, 1 + CHAINS // len(start)))
    gram = squares.gram(best)
    std = np.sqrt(variances(gram, problem.policy) * inflation) * scale
    x = without_open_part(best, gram, problem.policy)
    as_good = squares.half(x) <= squares.half(best) * (1 + SAME)
    return Refined(numbers.at(start + (x if as_good else best) * scale), numbers.spread(std))


def without_open_part(x: Array, gram: Array, policy: Policy) -> Array:
    """A change x (k,) without what the data leave open: a step there is rounding over nothing."""
    size, values, vectors = _correlation(gram)
    open_ = vectors[:, values < policy.open_eigenvalue]
    return np.asarray(x - open_ @ (open_.T @ (x * size)) / size)


def variances(gram: Array, policy: Policy) -> Array:
    """Diagonal (k,) of the inverse of a Gram matrix (k, k); infinite where the data leave a direction open."""
    size, values, vectors = _correlation(gram)
    open_ = values < policy.open_eigenvalue
    known = (vectors[:, ~open_] ** 2 / values[~open_]).sum(axis=1) / size**2
    return np.where((vectors[:, open_] ** 2).sum(axis=1) > policy.open_part, np.inf, known)


def _correlation(gram: Array) -> tuple[Array, Array, Array]:
    """Sizes (k,) of the parameters, eigenvalues (k,) and eigenvectors (k, k) of their correlation."""
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    values, vectors = np.linalg.eigh(gram / np.outer(size, size))
    return size, values, vectors
