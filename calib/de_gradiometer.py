"""Classic differential evolution of a magnetometer array: the comparison of the improved one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from calib.evolution import Box, Schedule, evolve, found
from calib.gradiometer import Problem
from calib.gradiometer_fit import Found, GradiometerCalibrator
from calib.reference import Reference
from sim.dataset import Recording


@dataclass(frozen=True)
class DeGradiometer(GradiometerCalibrator):
    """48 parameters of four sensors by DE/rand/1/bin with fixed F and CR [StornPrice1997].

    v = x_r1 + F (x_r2 - x_r3);  u_c = v_c with probability CR, else x_c;  the better of u and x stays
    [Ding2021] eq. 9 to 11

    F = `mutation` and CR = `crossover` are usual values: [Ding2021] compares over 0.2 to 0.9 and 0.2 to 1. Search space
    and stop as in `IdeGradiometer`.
    """

    name: ClassVar[str] = "de_gradiometer"
    summary: ClassVar[str] = "classic differential evolution (fixed F, CR) of a whole array"
    population: int = 50
    iterations: int = 10_000
    mutation: float = 0.5
    crossover: float = 0.9
    tolerance: float = 1e-6
    offset_fraction: float = 0.1
    scale_range: float = 0.2
    angle_deg: float = 5.0

    def search(self, task: Problem, recording: Recording, reference: Reference, rng: np.random.Generator) -> Found:
        """[StornPrice1997]."""
        schedule = Schedule(
            self.population, self.iterations, (self.mutation,) * 2, (self.crossover,) * 2, (1.0, 1.0), self.tolerance
        )
        low, high = Box(self.offset_fraction, self.scale_range, self.angle_deg).bounds(len(task.total))
        return found(evolve(task, low, high, schedule, rng), reference.strength_nT)
