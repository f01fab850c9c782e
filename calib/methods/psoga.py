"""The hybrid of particle swarm and genetic algorithm of [Zhang2018]."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from calib.families.norm_search import NormSpace, PopulationCalibrator
from calib.methods.ga import Ga
from calib.methods.pso import Pso
from calib.search.genetic import Heredity, SwarmWithHeredity
from calib.search.swarm import Swarm
from calib.settings import NotNegative, Positive, Probability


@dataclass(frozen=True)
class PsoGa(PopulationCalibrator):
    """The norm model's nine parameters by a swarm whose worse half evolves.

    Each iteration: move the swarm (`Pso`), sort by cost, keep the better half, cross and mutate the worse half (`Ga`),
    evaluate it, then update each particle's best and the leader.

    [Zhang2018] section 3.4. Settings as in the two parts. Cost, bounds, polish and covariance: `PopulationCalibrator`.
    """

    name: ClassVar[str] = "psoga"
    summary: ClassVar[str] = "hybrid of particle swarm and genetic algorithm on the norm cost (Zhang2018)"
    inertia: tuple[NotNegative, NotNegative] = Pso.inertia
    c1: NotNegative = Pso.c1
    c2: NotNegative = Pso.c2
    most_speed: Positive = Pso.most_speed
    crossing: tuple[Probability, Probability] = Ga.crossing
    mutating: tuple[Probability, Probability] = Ga.mutating
    mutation: NotNegative = Ga.mutation

    def move(self, space: NormSpace) -> SwarmWithHeredity:
        """[Zhang2018] section 3.4, fig. 4."""
        return SwarmWithHeredity(
            Swarm(self.inertia, self.c1, self.c2, self.most_speed, self.iterations),
            Heredity(self.crossing, self.mutating, self.mutation, space.strength_nT**2),
        )
