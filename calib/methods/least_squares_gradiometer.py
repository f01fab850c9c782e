"""Least squares of a magnetometer array by Levenberg-Marquardt."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from calib.families.gradiometer import ArrayEstimate, GradiometerCalibrator
from calib.methods.two_step_gradiometer import two_steps
from calib.models.sensor_array import ArrayObjective
from calib.reference import Reference
from recordings import Recording


@dataclass(frozen=True)
class LeastSquaresGradiometer(GradiometerCalibrator):
    """48 parameters of four sensors by Levenberg-Marquardt on the same objective as `IdeGradiometer`.

    (J^T J + mu D) dp = -J^T r,  r the residuals behind the objective  [Levenberg1944, Marquardt1963]

    `start`: "nominal", sensors without error, or "two_step", the result of `TwoStepGradiometer`. `polish` is the method
    itself: without it the start is the result.
    """

    name: ClassVar[str] = "least_squares_gradiometer"
    summary: ClassVar[str] = "Levenberg-Marquardt of a whole array from a nominal or a two-step start"
    start: Literal["nominal", "two_step"] = "nominal"

    def search(
        self, task: ArrayObjective, recording: Recording, reference: Reference, rng: np.random.Generator
    ) -> ArrayEstimate:
        """The start; the polish that follows is the method."""
        if self.start == "two_step":
            return two_steps(recording, reference)
        nominal = np.tile([0.0] * 3 + [1.0] * 3 + [0.0] * 6, len(task.total))
        return ArrayEstimate(nominal)
