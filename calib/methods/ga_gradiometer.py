"""Real-coded genetic algorithm on a magnetometer array: the comparison of differential evolution."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from calib.families.evolution import Evolved, EvolvingGradiometer
from calib.models.gradiometer import Array, Problem, residual_size, residuals
from calib.numerics.kernels import kernel


@kernel
def winner(cost: Array, rng: np.random.Generator) -> int:
    """The better of two random individuals of costs (NP,)."""
    one, other = int(rng.random() * len(cost)), int(rng.random() * len(cost))
    return one if cost[one] <= cost[other] else other


@kernel
def make_child(
    one: Array, other: Array, low: Array, high: Array, crossing: float, mutating: float, width: float,
    rng: np.random.Generator, child: Array,
) -> None:  # fmt: skip
    """Fill child (d,): evenly between and a quarter beyond its parents (BLX-0.25), or the first; normal mutations."""
    mixing = rng.random() < crossing
    for c in range(len(child)):
        child[c] = one[c]
        if mixing:
            child[c] += (1.5 * rng.random() - 0.25) * (other[c] - one[c])
        if rng.random() < mutating:
            child[c] += width * (high[c] - low[c]) * rng.normal()
        child[c] = min(max(child[c], low[c]), high[c])


@kernel
def breed(
    x: Array, task: Problem, low: Array, high: Array, settings: tuple[float, float, float],
    rng: np.random.Generator, out: Array, history: Array,
) -> None:  # fmt: skip
    """Run len(history) generations of x (NP, d) in place; the best individual stays and is the first in the end."""
    crossing, mutating, mutation = settings
    size, generations = len(x), len(history)
    cost, child = np.empty(size), np.empty(x.shape[1])
    for m in range(size):
        cost[m] = residuals(x[m], task, out)
    new, new_cost = x.copy(), cost.copy()
    for g in range(generations):
        best = int(np.argmin(cost))
        new[0], new_cost[0] = x[best], cost[best]
        width = mutation * (1.0 - g / generations)
        for m in range(1, size):
            make_child(x[winner(cost, rng)], x[winner(cost, rng)], low, high, crossing, mutating, width, rng, child)
            new[m] = child
            new_cost[m] = residuals(child, task, out)
        x[:], cost[:] = new, new_cost
        history[g] = math.sqrt(cost.min())
    x[0] = x[int(np.argmin(cost))]


@dataclass(frozen=True)
class GaGradiometer(EvolvingGradiometer):
    """48 parameters of four sensors by a real-coded genetic algorithm.

    Tournaments of two, blend crossover [EshelmanSchaffer1993] with probability `crossing`, normal mutation of each gene
    with probability `mutating` whose deviation falls evenly from `mutation` of the range to zero, and the best kept.
    [Ding2021] compares with a genetic algorithm but does not describe it: operators and settings are usual ones.
    """

    name: ClassVar[str] = "ga_gradiometer"
    summary: ClassVar[str] = "real-coded genetic algorithm of a whole array"
    crossing: float = 0.9
    mutating: float = 0.02
    mutation: float = 0.1

    def evolve(self, task: Problem, low: Array, high: Array, rng: np.random.Generator) -> Evolved:
        """Selection, crossover and mutation as above."""
        x = low + rng.random((self.population, len(low))) * (high - low)
        history = np.empty(self.iterations)
        settings = (self.crossing, self.mutating, self.mutation)
        breed(x, task, low, high, settings, rng, np.empty(residual_size(task)), history)
        return Evolved(x[0].copy(), history, False)
