"""Loop of the population searches: a move changes the population; the loop keeps the best, the history and the end."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from scenarios.arrays import Array

ROUNDING = 1e-24
"""A spread of costs below this is rounding, for costs of squared residuals of unit size."""


class Space(Protocol):
    """What is searched: bounds lower, upper (d,), equal where a parameter is fixed, and the cost of individuals."""

    @property
    def lower(self) -> Array:
        """Least parameters (d,)."""

    @property
    def upper(self) -> Array:
        """Greatest parameters (d,)."""

    def costs(self, individuals: Array) -> Array:
        """Costs (k,) of individuals (k, d)."""


@dataclass(eq=False)
class Population:
    """Individuals x (k, d) with their cost (k,), and the place and cost that count as each one's best."""

    x: Array
    cost: Array
    best: Array
    best_cost: Array

    @classmethod
    def spread(cls, space: Space, count: int, rng: np.random.Generator) -> Population:
        """Individuals even over the bounds."""
        x = space.lower + rng.random((count, len(space.lower))) * (space.upper - space.lower)
        cost = space.costs(x)
        return cls(x, cost, x.copy(), cost.copy())

    @property
    def leader(self) -> int:
        """Index of the individual with the best place."""
        return int(self.best_cost.argmin())

    def remember(self) -> None:
        """Update each individual's best with the present position."""
        better = self.cost < self.best_cost
        self.best[better] = self.x[better]
        self.best_cost[better] = self.cost[better]

    def forget(self) -> None:
        """Set each individual's best to the present position."""
        self.best, self.best_cost = self.x, self.cost

    def improve(self, trial: Array, cost: Array) -> None:
        """Replace each parent by the trial if the trial costs no more."""
        better = cost <= self.cost
        self.x[better] = trial[better]
        self.cost[better] = cost[better]

    def settled(self, tolerance: float) -> bool:
        """Whether sqrt(worst cost - best cost) is below this fraction of sqrt(best cost)."""
        least = self.cost.min()
        return bool(self.cost.max() - least <= max(tolerance**2 * least, ROUNDING))


class Move(ABC):
    """One generation: `advance` changes x and cost in place. `memory`: each individual remembers its best place."""

    memory: ClassVar[bool] = False

    def setup(self, population: Population, space: Space, rng: np.random.Generator) -> None:  # noqa: B027
        """Draw the random state of a move, before the first generation."""

    @abstractmethod
    def advance(self, population: Population, space: Space, generation: int, rng: np.random.Generator) -> None:
        """Move the population by a generation, numbered from 0."""


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Result of a search: best individual (d,), best cost after each generation, whether the search settled."""

    best: Array
    costs: Array
    settled: bool


def search(
    space: Space, move: Move, size: int, generations: int, rng: np.random.Generator, tolerance: float | None = None
) -> SearchResult:
    """Move a population of `size` for at most `generations`, fewer if settled to the tolerance."""
    population = Population.spread(space, size, rng)
    move.setup(population, space, rng)
    costs, settled = [], False
    for generation in range(generations):
        move.advance(population, space, generation, rng)
        if move.memory:
            population.remember()
        else:
            population.forget()
        costs.append(float(population.best_cost.min()))
        settled = tolerance is not None and population.settled(tolerance)
        if settled:
            break
    best = population.best[population.leader].copy()
    return SearchResult(best, np.array(costs), settled)
