"""Genetic algorithms with real numbers: selection, crossover and mutation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from calib.numerics.kernels import fast_kernel
from calib.search.population import Move, Population, Space
from calib.search.swarm import Swarm
from scenarios.arrays import Array


def fitness(cost: Array, unit: float) -> Array:
    """G = 1 / (1 + f), f the cost times its unit: [Zhang2018] eq. 23, in nT^2."""
    return np.asarray(1.0 / (1.0 + cost * unit))


def select(g: Array, rng: np.random.Generator) -> Array:
    """Indices (k,) of the parents: stochastic universal sampling of the cumulative probability of fitness g (k,).

    Pointers r + 2 i / k (modulo 1) after one random r: twice round the wheel in steps of 2 / k, as in [Zhang2018].
    """
    wheel = np.cumsum(g / g.sum())
    pointers = (rng.random() + 2.0 * np.arange(len(g)) / len(g)) % 1.0
    return np.minimum(np.searchsorted(wheel, pointers, side="right"), len(g) - 1)


@fast_kernel
def adapted(g: float, mean: float, most: float, usual: float, least: float) -> float:
    """Probability that falls from `usual` at the mean fitness or below to `least`, above zero, at the best."""
    if g < mean or most <= mean:
        return usual
    return usual - (usual - least) * (g - mean) / (most - mean)


@fast_kernel
def evolve(
    x: Array, g: Array, mean: float, most: float, crossing: tuple[float, float], mutating: tuple[float, float],
    step: Array, lower: Array, upper: Array, rng: np.random.Generator,
) -> None:  # fmt: skip
    """Cross pairs and mutate individuals x (k, d) of fitness g (k,), in place; step (d,): the largest mutation.

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
class Heredity:
    """Probabilities of crossing and mutating (usual, for the best), the largest mutation in parts of the range, and
    the unit that the fitness takes costs in."""

    crossing: tuple[float, float]
    mutating: tuple[float, float]
    mutation: float
    unit: float

    def evolve(self, x: Array, g: Array, all_g: Array, space: Space, rng: np.random.Generator) -> None:
        """`evolve` of individuals x (k, d) of fitness g (k,), out of a population of fitness all_g."""
        step = self.mutation * (space.upper - space.lower)
        evolve(
            x, g, all_g.mean(), all_g.max(), self.crossing, self.mutating, step, space.lower, space.upper, rng
        )  # fmt: skip


@dataclass(eq=False)
class Generation(Move):
    """A new generation of parents drawn by their fitness, crossed and mutated; no elite is kept."""

    heredity: Heredity

    def advance(self, population: Population, space: Space, generation: int, rng: np.random.Generator) -> None:
        """[Zhang2018] section 3.3."""
        g = fitness(population.cost, self.heredity.unit)
        parents = rng.permutation(select(g, rng))
        population.x = population.x[parents]
        self.heredity.evolve(population.x, g[parents], g, space, rng)
        population.cost = space.costs(population.x)


@dataclass(eq=False)
class SwarmWithHeredity(Move):
    """A swarm moves, then its worse half is crossed and mutated."""

    memory: ClassVar[bool] = True
    swarm: Swarm
    heredity: Heredity

    def setup(self, population: Population, space: Space, rng: np.random.Generator) -> None:
        """Draw the velocities."""
        self.swarm.setup(population, space, rng)

    def advance(self, population: Population, space: Space, generation: int, rng: np.random.Generator) -> None:
        """[Zhang2018] section 3.4, fig. 4."""
        self.swarm.advance(population, space, generation, rng)
        g = fitness(population.cost, self.heredity.unit)
        worse = rng.permutation(np.argsort(population.cost)[len(g) // 2 :])
        x = population.x[worse]
        self.heredity.evolve(x, g[worse], g, space, rng)
        population.x[worse] = x
        population.cost[worse] = space.costs(x)


@fast_kernel
def winner(cost: Array, rng: np.random.Generator) -> int:
    """The better of two random individuals of costs (k,)."""
    one, other = int(rng.random() * len(cost)), int(rng.random() * len(cost))
    return one if cost[one] <= cost[other] else other


@fast_kernel
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


@fast_kernel
def make_children(
    x: Array, cost: Array, low: Array, high: Array, crossing: float, mutating: float, width: float,
    rng: np.random.Generator, children: Array,
) -> None:  # fmt: skip
    """Fill children (k, d), each of two winners among x."""
    for child in children:
        one, other = winner(cost, rng), winner(cost, rng)
        make_child(x[one], x[other], low, high, crossing, mutating, width, rng, child)


@dataclass(eq=False)
class Tournament(Move):
    """Children of tournaments' winners beside the best of their parents' generation.

    Blend crossover [EshelmanSchaffer1993] with probability `crossing`; each gene mutates with probability `mutating`,
    by a normal deviate whose deviation falls evenly from `mutation` of the range to zero.
    """

    crossing: float
    mutating: float
    mutation: float
    generations: int

    def advance(self, population: Population, space: Space, generation: int, rng: np.random.Generator) -> None:
        """The best first, then the children."""
        x, cost = population.x, population.cost
        best, width = int(np.argmin(cost)), self.mutation * (1.0 - generation / self.generations)
        children = np.empty((len(x) - 1, x.shape[1]))
        make_children(x, cost, space.lower, space.upper, self.crossing, self.mutating, width, rng, children)
        population.x = np.concatenate((x[best : best + 1], children))
        population.cost = np.append(cost[best], space.costs(children))
