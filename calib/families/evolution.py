"""Evolution of a gradiometer's parameters: differential evolution, compiled, and what every population shares."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np

from calib.families.gradiometer import Found, GradiometerCalibrator
from calib.models.gradiometer import FIXED, Array, Problem, residual_size, residuals
from calib.numerics.kernels import kernel
from calib.reference import Reference
from calib.result import Status
from sim.dataset import Recording

ROUNDING = 1e-12
"""A spread of the objective below this fraction of F is rounding."""


class Schedule(NamedTuple):
    """How a differential evolution runs.

    `mutation` F, `crossover` CR and the probability `explore` of the strategy DE/rand/1 (else DE/target-to-best/2) are
    (at the start, at the end). `tolerance`: stop when sqrt(J_worst - J_best) is below this fraction of sqrt(J_best).
    """

    population: int
    iterations: int
    mutation: tuple[float, float]
    crossover: tuple[float, float]
    explore: tuple[float, float]
    tolerance: float


class Evolved(NamedTuple):
    """Best parameters, sqrt(J) of the best after each iteration (units of F), and whether the population settled."""

    best: Array
    history: Array
    settled: bool


@kernel
def fade(iteration: int, iterations: int) -> float:
    """lambda = exp(1 - G / (G + 1 - g)): 1 at the start and 0 at the end, falling late [Yan2006]."""
    return math.exp(1.0 - iterations / (iterations + 1.0 - iteration))


@kernel
def another(size: int, taken: tuple[int, int, int, int], rng: np.random.Generator) -> int:
    """A random index below size that is none of those taken."""
    while True:
        index = int(rng.random() * size)
        if index != taken[0] and index != taken[1] and index != taken[2] and index != taken[3]:
            return index


@kernel
def make_trial(
    x: Array, m: int, best: int, exploring: bool, factor: float, crossover: float, low: Array, high: Array,
    rng: np.random.Generator, trial: Array,
) -> None:  # fmt: skip
    """Fill trial (d,) for individual m of x (NP, d).

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


@kernel
def generations(
    x: Array, cost: Array, task: Problem, out: Array, low: Array, high: Array, schedule: Schedule,
    rng: np.random.Generator, history: Array,
) -> int:  # fmt: skip
    """Evolve x (NP, d) in place and fill the history; returns the number of iterations made."""
    new, trial = x.copy(), np.empty(x.shape[1])
    for m in range(x.shape[0]):
        cost[m] = residuals(x[m], task, out)
    for g in range(schedule.iterations):
        share = fade(g, schedule.iterations)
        factor = schedule.mutation[1] * (schedule.mutation[0] / schedule.mutation[1]) ** share
        crossover = schedule.crossover[1] + (schedule.crossover[0] - schedule.crossover[1]) * share
        explore = schedule.explore[0] + (schedule.explore[1] - schedule.explore[0]) * g / schedule.iterations
        best = int(np.argmin(cost))
        for m in range(x.shape[0]):
            make_trial(x, m, best, rng.random() < explore, factor, crossover, low, high, rng, trial)
            value = residuals(trial, task, out)
            if value <= cost[m]:
                cost[m] = value
                new[m] = trial
        x[:] = new
        least = cost.min()
        history[g] = math.sqrt(least)
        if cost.max() - least <= max(schedule.tolerance**2 * least, ROUNDING**2):
            return g + 1
    return schedule.iterations


def differential_evolution(
    task: Problem, low: Array, high: Array, schedule: Schedule, rng: np.random.Generator
) -> Evolved:
    """Minimise the objective within bounds low, high (12 k,), equal where a parameter is fixed."""
    x = low + rng.random((schedule.population, len(low))) * (high - low)
    cost, history = np.empty(schedule.population), np.empty(schedule.iterations)
    out = np.empty(residual_size(task))
    made = generations(x, cost, task, out, low, high, schedule, rng, history)
    return Evolved(x[int(cost.argmin())].copy(), history[:made], made < schedule.iterations)


@dataclass(frozen=True)
class EvolvingGradiometer(GradiometerCalibrator):
    """A whole array by a population within bounds; a subclass writes `evolve`.

    Search space: offsets within +-`offset_fraction` F, scale factors 1 +- `scale_range`, angles +-`angle_deg`;
    [Ding2021] has 0.004, 0.1 and 2. The rest: `GradiometerCalibrator`.
    """

    population: int = 50
    iterations: int = 10_000
    offset_fraction: float = 0.1
    scale_range: float = 0.2
    angle_deg: float = 5.0

    @abstractmethod
    def evolve(self, task: Problem, low: Array, high: Array, rng: np.random.Generator) -> Evolved:
        """The method itself, within bounds low, high (12 k,)."""

    @final
    def search(self, task: Problem, recording: Recording, reference: Reference, rng: np.random.Generator) -> Found:
        """The best of the last population, with its history in nT."""
        evolved = self.evolve(task, *self.bounds(len(task.total)), rng)
        history = tuple((evolved.history * reference.strength_nT).tolist())
        status = Status.settled(
            evolved.settled,
            f"after {len(history)} iterations the population has not settled (objective rms "
            f"{history[-1]:.3g} nT): use polish = true, more iterations or a larger population",
        )
        return Found(evolved.best, history, status)

    def bounds(self, k: int) -> tuple[Array, Array]:
        """Least and greatest parameters (12 k,) of k sensors; equal for sensor 1's misalignment."""
        reach = np.tile([self.offset_fraction] * 3 + [self.scale_range] * 3 + [math.radians(self.angle_deg)] * 6, k)
        reach[list(FIXED)] = 0.0
        middle = np.tile([0.0] * 3 + [1.0] * 3 + [0.0] * 6, k)
        return middle - reach, middle + reach
