"""Particle swarm optimisation of the nine parameters of the norm model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from calib.families.norm_search import NormSpace, PopulationCalibrator
from calib.search.swarm import Swarm
from calib.settings import NotNegative, Positive


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
    inertia: tuple[NotNegative, NotNegative] = (0.95, 0.4)
    c1: NotNegative = 2.0
    c2: NotNegative = 2.0
    most_speed: Positive = 0.2

    def move(self, space: NormSpace) -> Swarm:
        """[Zhang2018] section 3.2."""
        return Swarm(self.inertia, self.c1, self.c2, self.most_speed, self.iterations)
