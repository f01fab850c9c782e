"""Improved differential evolution: all the parameters of a magnetometer array in one search."""

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
class IdeGradiometer(GradiometerCalibrator):
    """48 parameters of four sensors by differential evolution with two strategies and varying F and CR.

    DE/rand/1/bin where rand < phi, else DE/target-to-best/2/bin;  phi = phi_max - (phi_max - phi_min) g / G
    F = F0 2^l,  CR = CR0 2^(l - 1),  l = exp(1 - G / (G + 1 - g))     [Ding2021] eq. 12 to 15

    g the iteration, G = `iterations`. phi falls evenly; F is the form of the cited [Yan2006], from 2 F0 to F0; the form
    of CR is lost in print: the same law, from CR0 to half of it. Stops early when the population has settled to
    `tolerance`. Search space: offsets within +-`offset_fraction` F, scale factors 1 +- `scale_range`, angles
    +-`angle_deg`; [Ding2021] has 0.004, 0.1 and 2. The rest: `GradiometerCalibrator`.
    """

    name: ClassVar[str] = "ide_gradiometer"
    summary: ClassVar[str] = "improved differential evolution of a whole array, 48 parameters (Ding2021)"
    population: int = 50
    iterations: int = 10_000
    mutation: float = 0.3
    crossover: float = 0.8
    explore_most: float = 1.0
    explore_least: float = 0.1
    tolerance: float = 1e-6
    offset_fraction: float = 0.1
    scale_range: float = 0.2
    angle_deg: float = 5.0

    def search(self, task: Problem, recording: Recording, reference: Reference, rng: np.random.Generator) -> Found:
        """[Ding2021] section 2."""
        schedule = Schedule(
            self.population,
            self.iterations,
            (2 * self.mutation, self.mutation),
            (self.crossover, self.crossover / 2),
            (self.explore_most, self.explore_least),
            self.tolerance,
        )
        low, high = Box(self.offset_fraction, self.scale_range, self.angle_deg).bounds(len(task.total))
        return found(evolve(task, low, high, schedule, rng), reference.strength_nT)
