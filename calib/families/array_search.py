"""Calibration of a whole array by a population within bounds."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import Annotated, final

import numpy as np
from pydantic import Field

from calib.families.gradiometer import ArrayEstimate, GradiometerCalibrator
from calib.models.sensor_array import FIXED, ArrayObjective, array_costs, residual_size
from calib.reference import Reference
from calib.result import Status
from calib.search.population import Move, search
from calib.settings import Count, NotNegative, Positive
from recordings import Recording
from scenarios.arrays import Array
from scenarios.text import figure


@dataclass(frozen=True, eq=False)
class ArraySpace:
    """The objective within bounds lower, upper (12 k,) of the parameters of k sensors."""

    task: ArrayObjective
    lower: Array
    upper: Array

    def costs(self, individuals: Array) -> Array:
        """J (m,) of parameters (m, 12 k)."""
        return np.asarray(array_costs(individuals, self.task, np.empty(residual_size(self.task))))


@dataclass(frozen=True)
class EvolvingGradiometer(GradiometerCalibrator):
    """A whole array by a population within bounds; a subclass writes `move`.

    Search space: offsets within +-`offset_fraction` F, scale factors 1 +- `scale_range`, angles +-`angle_deg`;
    [Ding2021] has 0.004, 0.1 and 2. `tolerance`: stop when the objective's roots differ by less than this fraction over
    the population; None runs all `iterations`. The rest: `GradiometerCalibrator`.
    """

    population: Annotated[int, Field(ge=5)] = 50
    iterations: Count = 10_000
    offset_fraction: Positive = 0.1
    scale_range: Annotated[float, Field(gt=0, lt=1)] = 0.2
    angle_deg: Annotated[float, Field(gt=0, lt=90)] = 5.0
    tolerance: NotNegative | None = 1e-6

    @abstractmethod
    def move(self) -> Move:
        """The method itself: what a generation does."""

    @final
    def search(
        self, task: ArrayObjective, recording: Recording, reference: Reference, rng: np.random.Generator
    ) -> ArrayEstimate:
        """The best of the last population, with its history in nT."""
        space = ArraySpace(task, *self.bounds(len(task.total)))
        found = search(space, self.move(), self.population, self.iterations, rng, self.tolerance)
        history = tuple((np.sqrt(found.costs) * reference.strength_nT).tolist())
        status = Status.settled(
            found.settled,
            f"after {len(history)} iterations the population has not settled (objective rms "
            f"{figure(history[-1])} nT): use polish = true, more iterations or a larger population",
        )
        return ArrayEstimate(found.best, history, status)

    def bounds(self, k: int) -> tuple[Array, Array]:
        """Least and greatest parameters (12 k,) of k sensors; equal for sensor 1's misalignment."""
        reach = np.tile([self.offset_fraction] * 3 + [self.scale_range] * 3 + [math.radians(self.angle_deg)] * 6, k)
        reach[list(FIXED)] = 0.0
        middle = np.tile([0.0] * 3 + [1.0] * 3 + [0.0] * 6, k)
        return middle - reach, middle + reach
