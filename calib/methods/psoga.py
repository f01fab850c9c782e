"""The hybrid of particle swarm and genetic algorithm of [Zhang2018]."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from calib.families.population import PopulationCalibrator, Problem, Search
from calib.methods.ga import Ga, evolve, fitness
from calib.methods.pso import Pso, Swarm


@dataclass(frozen=True)
class PsoGa(PopulationCalibrator):
    """The norm model's nine parameters by a swarm whose worse half evolves.

    Each iteration: move the swarm (`Pso`), sort by cost, keep the better half, cross and mutate the worse half (`Ga`),
    evaluate it, then update each particle's best and the leader.

    [Zhang2018] section 3.4. Settings as in the two parts. Cost, bounds, polish and covariance: `PopulationCalibrator`.
    """

    name: ClassVar[str] = "psoga"
    summary: ClassVar[str] = "hybrid of particle swarm and genetic algorithm on the norm cost (Zhang2018)"
    inertia: tuple[float, float] = Pso.inertia
    c1: float = Pso.c1
    c2: float = Pso.c2
    most_speed: float = Pso.most_speed
    crossing: tuple[float, float] = Ga.crossing
    mutating: tuple[float, float] = Ga.mutating
    mutation: float = Ga.mutation

    def search(self, problem: Problem, rng: np.random.Generator) -> Search:
        """[Zhang2018] section 3.4, fig. 4."""
        pso = Pso(
            self.population, self.iterations, inertia=self.inertia, c1=self.c1, c2=self.c2, most_speed=self.most_speed
        )
        swarm = Swarm.begin(problem, self.population, pso.fastest(problem), rng)
        history = np.empty(self.iterations)
        for t in range(self.iterations):
            pso.move(swarm, problem, t, rng)
            swarm.cost = problem.costs(swarm.x)
            self._evolve_worse_half(swarm, problem, rng)
            swarm.remember()
            history[t] = swarm.own_cost.min()
        return Search(swarm.own[swarm.leader].copy(), history)

    def _evolve_worse_half(self, swarm: Swarm, problem: Problem, rng: np.random.Generator) -> None:
        g = fitness(problem, swarm.cost)
        worse = rng.permutation(np.argsort(swarm.cost)[len(g) // 2 :])
        x = swarm.x[worse]
        evolve(
            x,
            g[worse],
            g.mean(),
            g.max(),
            self.crossing,
            self.mutating,
            self.mutation * (problem.upper - problem.lower),
            problem.lower,
            problem.upper,
            rng,
        )
        swarm.x[worse] = x
        swarm.cost[worse] = problem.costs(x)
