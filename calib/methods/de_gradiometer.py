"""Classic differential evolution of a magnetometer array: the comparison of the improved one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from calib.families.array_search import EvolvingGradiometer
from calib.search.differential import Schedule, TwoStrategies
from calib.settings import Positive, Probability


@dataclass(frozen=True)
class DeGradiometer(EvolvingGradiometer):
    """48 parameters of four sensors by DE/rand/1/bin with fixed F and CR [StornPrice1997].

    v = x_r1 + F (x_r2 - x_r3);  u_c = v_c with probability CR, else x_c;  the better of u and x stays
    [Ding2021] eq. 9 to 11

    F = `mutation` and CR = `crossover` are usual values: [Ding2021] compares over 0.2 to 0.9 and 0.2 to 1. Stop as
    in `IdeGradiometer`.
    """

    name: ClassVar[str] = "de_gradiometer"
    summary: ClassVar[str] = "classic differential evolution (fixed F, CR) of a whole array"
    mutation: Positive = 0.5
    crossover: Probability = 0.9

    def move(self) -> TwoStrategies:
        """[StornPrice1997]."""
        fixed = (self.mutation,) * 2, (self.crossover,) * 2, (1.0, 1.0)
        return TwoStrategies(Schedule(*fixed, self.iterations))
