"""Real-coded genetic algorithm on a magnetometer array: the comparison of differential evolution."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from calib.families.array_search import EvolvingGradiometer
from calib.search.genetic import Tournament
from calib.settings import NotNegative, Probability


@dataclass(frozen=True)
class GaGradiometer(EvolvingGradiometer):
    """48 parameters of four sensors by a real-coded genetic algorithm.

    Tournaments of two, blend crossover [EshelmanSchaffer1993] with probability `crossing`, normal mutation of each gene
    with probability `mutating` whose deviation falls evenly from `mutation` of the range to zero, and the best kept.
    [Ding2021] compares with a genetic algorithm but does not describe it: operators and settings are usual ones.
    """

    name: ClassVar[str] = "ga_gradiometer"
    summary: ClassVar[str] = "real-coded genetic algorithm of a whole array"
    crossing: Probability = 0.9
    mutating: Probability = 0.02
    mutation: NotNegative = 0.1
    tolerance: NotNegative | None = None

    def move(self) -> Tournament:
        """Selection, crossover and mutation as above."""
        return Tournament(self.crossing, self.mutating, self.mutation, self.iterations)
