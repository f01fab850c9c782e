"""Adaptive real-coded genetic algorithm on the nine parameters of the norm model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from calib.families.population import Array, PopulationCalibrator, Problem, Search
from calib.numerics.kernels import kernel


def fitness(problem: Problem, cost: Array) -> Array:
    """G = 1 / (1 + f), f in nT^2: [Zhang2018] eq. 23."""
    return np.asarray(1.0 / (1.0 + cost * problem.strength_nT**2))


def select(g: Array, rng: np.random.Generator) -> Array:
    """Indices (k,) of the parents: stochastic universal sampling of the cumulative probability of fitness g (k,).

    Pointers r + 2 i / k (modulo 1) after one random r: twice round the wheel in steps of 2 / k, as in [Zhang2018].
    """
    wheel = np.cumsum(g / g.sum())
    pointers = (rng.random() + 2.0 * np.arange(len(g)) / len(g)) % 1.0
    return np.minimum(np.searchsorted(wheel, pointers, side="right"), len(g) - 1)


@kernel
def adapted(g: float, mean: float, most: float, usual: float, least: float) -> float:
    """Probability that falls from `usual` at the mean fitness or below to `least`, above zero, at the best."""
    if g < mean or most <= mean:
        return usual
    return usual - (usual - least) * (g - mean) / (most - mean)


@kernel
def evolve(
    x: Array, g: Array, mean: float, most: float, crossing: tuple[float, float], mutating: tuple[float, float],
    step: Array, lower: Array, upper: Array, rng: np.random.Generator,
) -> None:  # fmt: skip
    """Cross pairs and mutate individuals x (k, 9) of fitness g (k,), in place; step (9,): the largest mutation.

    Pairs are neighbours: shuffle before. mean and most: of the fitness of the whole population.
    """
    for k in range(0, x.shape[0] - 1, 2):
        if rng.random() < adapted(max(g[k], g[k + 1]), mean, most, crossing[0], crossing[1]):
            share = rng.random()
            for j in range(x.shape[1]):
                one, other = x[k, j], x[k + 1, j]
                x[k, j] = share * one + (1.0 - share) * other
                x[k + 1, j] = share * other + (1.0 - share) * one
    for k in range(x.shape[0]):
        if rng.random() < adapted(g[k], mean, most, mutating[0], mutating[1]):
            for j in range(x.shape[1]):
                x[k, j] = min(max(x[k, j] + step[j] * (2.0 * rng.random() - 1.0), lower[j]), upper[j])


@dataclass(frozen=True)
class Ga(PopulationCalibrator):
    """The norm model's nine parameters by a real-coded, adaptive genetic algorithm.

    G = 1 / (1 + f);  p = p_1 - (p_1 - p_2) (G' - G_mean) / (G_max - G_mean) where G' >= G_mean, else p_1

    [Zhang2018] section 3.3: selection by evenly stepped pointers, arithmetic crossover (a x + (1 - a) y), mutation by a
    small +-delta. Probabilities adapt to the fitness [SrinivasPatnaik1994], in the improved form in which the best
    individual too crosses and mutates (p_2 > 0). No elite is kept: the best of a generation can be lost, and the
    answer is the best of the last. The paper gives no values; chosen: `crossing` 0.9 to 0.6, `mutating` 0.1 to 0.001,
    delta even up to `mutation` of the range. Cost, bounds, polish and covariance: `PopulationCalibrator`.
    """

    name: ClassVar[str] = "ga"
    summary: ClassVar[str] = "adaptive genetic algorithm on the norm cost, 9 parameters (Zhang2018)"
    crossing: tuple[float, float] = (0.9, 0.6)
    mutating: tuple[float, float] = (0.1, 0.001)
    mutation: float = 0.02

    def search(self, problem: Problem, rng: np.random.Generator) -> Search:
        """[Zhang2018] section 3.3."""
        x = problem.start(self.population, rng)
        cost = problem.costs(x)
        step = self.mutation * (problem.upper - problem.lower)
        history = np.empty(self.iterations)
        for t in range(self.iterations):
            g = fitness(problem, cost)
            parents = rng.permutation(select(g, rng))
            x, inherited = x[parents], g[parents]
            evolve(
                x, inherited, g.mean(), g.max(), self.crossing, self.mutating, step, problem.lower, problem.upper, rng
            )
            cost = problem.costs(x)
            history[t] = cost.min()
        return Search(x[int(cost.argmin())].copy(), history)
