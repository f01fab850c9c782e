"""Particle swarm optimisation of the nine parameters of the norm model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from calib.families.population import Array, PopulationCalibrator, Problem, Search
from calib.numerics.kernels import kernel


@kernel
def fly(
    x: Array, v: Array, own: Array, leader: Array, inertia: float, c1: float, c2: float,
    fastest: Array, lower: Array, upper: Array, rng: np.random.Generator,
) -> None:  # fmt: skip
    """One move of all particles, in place: x, v, own best (k, 9); leader, fastest, lower, upper (9,)."""
    for k in range(x.shape[0]):
        for j in range(x.shape[1]):
            speed = inertia * v[k, j] + c1 * rng.random() * (own[k, j] - x[k, j])
            speed += c2 * rng.random() * (leader[j] - x[k, j])
            speed = min(max(speed, -fastest[j]), fastest[j])
            place = x[k, j] + speed
            if place < lower[j] or place > upper[j]:
                place = min(max(place, lower[j]), upper[j])
                speed = 0.0
            x[k, j] = place
            v[k, j] = speed


@dataclass
class Swarm:
    """Particles x (k, 9), their velocities, costs, and the best place and cost that each has seen."""

    x: Array
    v: Array
    cost: Array
    own: Array
    own_cost: Array

    @classmethod
    def begin(cls, problem: Problem, count: int, fastest: Array, rng: np.random.Generator) -> Swarm:
        """Places even over the bounds, velocities even up to the fastest."""
        x = problem.start(count, rng)
        cost = problem.costs(x)
        return cls(x, fastest * rng.uniform(-1.0, 1.0, x.shape), cost, x.copy(), cost.copy())

    @property
    def leader(self) -> int:
        """Index of the particle that has seen the best place."""
        return int(self.own_cost.argmin())

    def remember(self) -> None:
        """Update each particle's best with where it is."""
        better = self.cost < self.own_cost
        self.own[better] = self.x[better]
        self.own_cost[better] = self.cost[better]


@dataclass(frozen=True)
class Pso(PopulationCalibrator):
    """The norm model's nine parameters by particle swarm optimisation.

    v <- w v + c1 r1 (pbest - x) + c2 r2 (gbest - x),  x <- x + v,  w = w_max - (w_max - w_min) t / T

    [Zhang2018] eq. 16 to 22; cost, bounds, polish and covariance: `PopulationCalibrator`. The paper states the inertia
    (0.95 to 0.4) but neither c1, c2 nor what happens at the bounds. Chosen: c1 = c2 = 2, the original swarm's;
    velocity at most `most_speed` of the range an iteration; a particle that would leave stops at the wall.
    With c1 + c2 = 4 the swarm contracts only where 4 < 24 (1 - w^2) / (7 - 5 w), w < 0.41: the last moves of the run.
    """

    name: ClassVar[str] = "pso"
    summary: ClassVar[str] = "particle swarm on the norm cost, 9 parameters (Zhang2018); rotation not observable"
    inertia: tuple[float, float] = (0.95, 0.4)
    c1: float = 2.0
    c2: float = 2.0
    most_speed: float = 0.2

    def search(self, problem: Problem, rng: np.random.Generator) -> Search:
        """[Zhang2018] section 3.2."""
        swarm = Swarm.begin(problem, self.population, self.fastest(problem), rng)
        history = np.empty(self.iterations)
        for t in range(self.iterations):
            self.move(swarm, problem, t, rng)
            swarm.cost = problem.costs(swarm.x)
            swarm.remember()
            history[t] = swarm.own_cost.min()
        return Search(swarm.own[swarm.leader].copy(), history)

    def fastest(self, problem: Problem) -> Array:
        """Largest speed (9,) an iteration."""
        return self.most_speed * (problem.upper - problem.lower)

    def move(self, swarm: Swarm, problem: Problem, t: int, rng: np.random.Generator) -> None:
        """Velocities and places of iteration t (0-based), eq. 19 to 21."""
        most, least = self.inertia
        inertia = most - (most - least) * (t + 1) / self.iterations
        fly(
            swarm.x,
            swarm.v,
            swarm.own,
            swarm.own[swarm.leader].copy(),
            inertia,
            self.c1,
            self.c2,
            self.fastest(problem),
            problem.lower,
            problem.upper,
            rng,
        )
