"""Ellipsoid fit: nine parameters from the field's strength alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from calib.base import Calibrator
from calib.models.ellipsoid import EllipsoidFit, Standardised
from calib.models.quadric import QuadricFit, fit_ellipsoid_specific, refit
from calib.observability import Extent, unobservable
from calib.reference import Reference
from calib.result import Calibration, Status
from calib.settings import Count, Positive
from recordings import Recording
from scenarios.arrays import Array
from scenarios.text import figure

MANY = 20_000
"""Samples, evenly spaced, that suffice for a first estimate: refits to all samples start from there."""


@dataclass(frozen=True)
class EllipsoidCalibrator(Calibrator):
    """Offset and symmetric S from |h| = F, by an ellipsoid-specific fit and noise-adjusted rounds.

    m = S h + b, |h| = F:  (m - b)^T (S S)^-1 (m - b) = F^2

    The points, centred and scaled, get the quadric that is an ellipsoid by constraint [LiGriffiths2004]; `rounds` of
    noise-adjusted, gradient-weighted refits [Kanatani1994] then remove its bias, and the result is checked to be an
    ellipsoid again. The strength says nothing of a rotation: S = F^-1 T^(1/2) is the symmetric positive definite choice
    (polar decomposition), so a misalignment of the sensor stays in the corrected field.
    Covariance: linearised at the solution, noise from the residual. [Zhang2018] for the model.
    """

    name: ClassVar[str] = "ellipsoid"
    summary: ClassVar[str] = "9-parameter ellipsoid fit from the field strength; no attitude; rotation not observable"
    min_samples: ClassVar[int] = 10
    rounds: Count = 8
    tolerance: Positive = 1e-3

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        scaled = Standardised.of(recording.mag_nT)
        step = max(1, len(scaled.x) // MANY)
        first = fit_ellipsoid_specific(np.ascontiguousarray(scaled.x[::step]))
        if step > 1:
            first = self._rounds(np.ascontiguousarray(scaled.x[::step]), first)[0].theta
        fit, history, settled = self._rounds(scaled.x, first)
        estimate = EllipsoidFit.of_quadric(fit.theta, fit.covariance, fit.noise_std, history)
        if estimate is None:
            why = "the quadric that fits the measurements best is not an ellipsoid"
            return unobservable(Extent.of(recording.mag_nT).thinnest, why)
        status = Status.settled(
            settled,
            f"after {self.rounds} rounds the estimate still moves by {figure(history[-1], 2)} standard deviations",
        )
        return scaled.calibration(self.name, status, estimate, reference)

    def _rounds(self, x: Array, theta: Array) -> tuple[QuadricFit, tuple[float, ...], bool]:
        """Refits from a first theta (10,) until theta moves by less than `tolerance` of its standard deviation."""
        fit = refit(x, theta)
        history: list[float] = []
        for _ in range(self.rounds):
            new = refit(x, fit.theta)
            std = np.sqrt(np.diag(new.covariance)) + 1e-9 * float(np.linalg.norm(new.theta))
            history.append(float(np.abs((new.theta - fit.theta) / std).max()))
            fit = new
            if history[-1] < self.tolerance:
                return fit, tuple(history), True
        return fit, tuple(history), False
