"""Improved differential evolution: all the parameters of a magnetometer array in one search."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from calib.families.array_search import EvolvingGradiometer
from calib.search.differential import Schedule, TwoStrategies
from calib.settings import Positive, Probability


@dataclass(frozen=True)
class IdeGradiometer(EvolvingGradiometer):
    """48 parameters of four sensors by differential evolution with two strategies and varying F and CR.

    DE/rand/1/bin where rand < phi, else DE/target-to-best/2/bin;  phi = phi_max - (phi_max - phi_min) g / G
    F = F0 2^l,  CR = CR0 2^(l - 1),  l = exp(1 - G / (G + 1 - g))     [Ding2021] eq. 12 to 15

    g the iteration, G = `iterations`. phi falls evenly; F is the form of the cited [Yan2006], from 2 F0 to F0; the form
    of CR is lost in print: the same law, from CR0 to half of it. Stops early when the population has settled to
    `tolerance`. Search space: `EvolvingGradiometer`.
    """

    name: ClassVar[str] = "ide_gradiometer"
    summary: ClassVar[str] = "improved differential evolution of a whole array, 48 parameters (Ding2021)"
    mutation: Positive = 0.3
    crossover: Probability = 0.8
    explore_most: Probability = 1.0
    explore_least: Probability = 0.1

    def move(self) -> TwoStrategies:
        """[Ding2021] section 2."""
        return TwoStrategies(
            Schedule(
                factor=(2 * self.mutation, self.mutation),
                crossover=(self.crossover, self.crossover / 2),
                explore=(self.explore_most, self.explore_least),
                generations=self.iterations,
            )
        )
