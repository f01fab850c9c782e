"""Differential evolution: a trial for each individual replaces the individual if no worse."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from calib.numerics.kernels import fast_kernel
from calib.search.population import Move, Population, Space
from scenarios.arrays import Array


@dataclass(eq=False)
class RandOne(Move):
    """DE/rand/1/bin: v = x_r1 + F (x_r2 - x_r3);  u_j = v_j where rand < CR or j = j_r, else x_j.

    r1, r2, r3 differ from each other and from the parent; an entry of v out of bounds is drawn anew.
    """

    factor: float
    crossing: float

    def advance(self, population: Population, space: Space, generation: int, rng: np.random.Generator) -> None:
        """[StornPrice1997]."""
        trial = self.trial(population.x, space, rng)
        population.improve(trial, space.costs(trial))

    def trial(self, x: Array, space: Space, rng: np.random.Generator) -> Array:
        """Mutants of x (k, d) crossed with their parents."""
        k, d = x.shape
        order = rng.random((k, k))
        np.fill_diagonal(order, 2.0)
        one, two, three = np.argpartition(order, (0, 1, 2), axis=1)[:, :3].T
        mutant = x[one] + self.factor * (x[two] - x[three])
        anew = rng.uniform(space.lower, space.upper, (k, d))
        mutant = np.where((mutant < space.lower) | (mutant > space.upper), anew, mutant)
        crossed = rng.random((k, d)) < self.crossing
        crossed[np.arange(k), rng.integers(0, d, k)] = True
        return np.asarray(np.where(crossed, mutant, x))


class Schedule(NamedTuple):
    """Factor F, crossover CR and the probability `explore` of the strategy DE/rand/1 (else DE/target-to-best/2), each
    (at the start, at the end of the generations)."""

    factor: tuple[float, float]
    crossover: tuple[float, float]
    explore: tuple[float, float]
    generations: int

    def at(self, generation: int) -> tuple[float, float, float]:
        """F, CR and the probability in a generation: F and CR fade late, the probability evenly.

        F = F1 (F0 / F1)^l,  CR = CR1 + (CR0 - CR1) l,  l = exp(1 - G / (G + 1 - g))  [Yan2006]
        """
        fade = math.exp(1.0 - self.generations / (self.generations + 1.0 - generation))
        factor = self.factor[1] * (self.factor[0] / self.factor[1]) ** fade
        crossover = self.crossover[1] + (self.crossover[0] - self.crossover[1]) * fade
        explore = self.explore[0] + (self.explore[1] - self.explore[0]) * generation / self.generations
        return factor, crossover, explore


@fast_kernel
def another(size: int, taken: tuple[int, int, int, int], rng: np.random.Generator) -> int:
    """A random index below size that is none of those taken."""
    while True:
        index = int(rng.random() * size)
        if index != taken[0] and index != taken[1] and index != taken[2] and index != taken[3]:
            return index


@fast_kernel
def make_trial(
    x: Array, m: int, best: int, exploring: bool, factor: float, crossover: float, low: Array, high: Array,
    rng: np.random.Generator, trial: Array,
) -> None:  # fmt: skip
    """Fill trial (d,) for individual m of x (k, d).

    DE/rand/1:            v = x_r1 + F (x_r2 - x_r3)
    DE/target-to-best/2:  v = x_m + F (x_best - x_m) + F (x_r1 - x_r2) + F (x_r3 - x_r4)
    Binomial crossover takes v with probability CR; a value out of bounds goes half way from x_m to the bound.
    """
    size, d = x.shape
    r1 = another(size, (m, m, m, m), rng)
    r2 = another(size, (m, r1, r1, r1), rng)
    r3 = another(size, (m, r1, r2, r2), rng)
    r4 = another(size, (m, r1, r2, r3), rng)
    sure = int(rng.random() * d)
    for c in range(d):
        trial[c] = x[m, c]
        if c != sure and rng.random() >= crossover:
            continue
        if exploring:
            value = x[r1, c] + factor * (x[r2, c] - x[r3, c])
        else:
            value = x[m, c] + factor * (x[best, c] - x[m, c] + x[r1, c] - x[r2, c] + x[r3, c] - x[r4, c])
        if value < low[c]:
            value = 0.5 * (x[m, c] + low[c])
        elif value > high[c]:
            value = 0.5 * (x[m, c] + high[c])
        trial[c] = value


@fast_kernel
def make_trials(
    x: Array, best: int, explore: float, factor: float, crossover: float, low: Array, high: Array,
    rng: np.random.Generator, trials: Array,
) -> None:  # fmt: skip
    """Fill a trial for each individual."""
    for m in range(len(x)):
        make_trial(x, m, best, rng.random() < explore, factor, crossover, low, high, rng, trials[m])


@dataclass(eq=False)
class TwoStrategies(Move):
    """DE/rand/1 or DE/target-to-best/2, drawn for each individual, on a schedule."""

    schedule: Schedule

    def advance(self, population: Population, space: Space, generation: int, rng: np.random.Generator) -> None:
        """[Ding2021] eq. 12 to 15."""
        factor, crossover, explore = self.schedule.at(generation)
        trials = np.empty_like(population.x)
        best = int(np.argmin(population.cost))
        make_trials(population.x, best, explore, factor, crossover, space.lower, space.upper, rng, trials)
        population.improve(trials, space.costs(trials))
