"""Adaptive real-coded genetic algorithm on the nine parameters of the norm model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from calib.families.norm_search import NormSpace, PopulationCalibrator
from calib.search.genetic import Generation, Heredity
from calib.settings import NotNegative, Probability


@dataclass(frozen=True)
class Ga(PopulationCalibrator):
    """The norm model's nine parameters by a real-coded, adaptive genetic algorithm.

    G = 1 / (1 + f);  p = p_1 - (p_1 - p_2) (G' - G_mean) / (G_max - G_mean) where G' >= G_mean, else p_1

    [Zhang2018] section 3.3: selection by evenly stepped pointers, arithmetic crossover (a x + (1 - a) y), mutation by a
    small +-delta. Probabilities adapt to the fitness [SrinivasPatnaik1994], in the improved form in which the best
    individual too crosses and mutates (p_2 > 0). No elite is kept: the best of a generation can be lost, and the
    answer is the best of the last. The paper gives no values; chosen: `crossing` 0.9 to 0.6, `mutating` 0.1 to 0.001,
    delta even up to `mutation` of the range. Cost, bounds, polish and covariance: `PopulationCalibrator`.
    """

    name: ClassVar[str] = "ga"
    summary: ClassVar[str] = "adaptive genetic algorithm on the norm cost, 9 parameters (Zhang2018)"
    crossing: tuple[Probability, Probability] = (0.9, 0.6)
    mutating: tuple[Probability, Probability] = (0.1, 0.001)
    mutation: NotNegative = 0.02

    def move(self, space: NormSpace) -> Generation:
        """[Zhang2018] section 3.3."""
        return Generation(Heredity(self.crossing, self.mutating, self.mutation, space.strength_nT**2))
