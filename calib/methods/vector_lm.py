"""Levenberg-Marquardt on the 21 parameters of the vector model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.optimize import OptimizeResult, least_squares

from calib.base import Calibrator
from calib.models.vector import VectorData, calibration
from calib.reference import Reference
from calib.result import Calibration, Status
from calib.settings import Count, Positive
from recordings import Recording
from scenarios.arrays import Array

MAX_CONDITION = 1e7


@dataclass(frozen=True)
class VectorLmCalibrator(Calibrator):
    """T_p, A and B by Levenberg-Marquardt (MINPACK's lmder) on the vector model's residual.

    min |T_m - T - H x|^2,  x = (T_p, A, B),  each parameter in units of 1 / |its column|  ([Li2017] eq. 2)

    The model is linear in x, so the method agrees with least squares from any start, in a few evaluations; the paper's
    comparison, whose Levenberg-Marquardt ends far above the raw error, is of the nonlinear equations of the total field
    (see the reproduction). Covariance: inverse normal matrix times the residual variance.
    """

    name: ClassVar[str] = "vector_lm"
    summary: ClassVar[str] = "Levenberg-Marquardt on the 21-parameter vector model, well scaled"
    needs: ClassVar[tuple[str, ...]] = ("attitude", "field_vector")
    min_samples: ClassVar[int] = 8
    eddy: ClassVar[bool] = True
    tolerance: Positive = 1e-15
    max_evaluations: Count = 100

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        data, unit = VectorData.of(recording, reference), reference.strength_nT
        H, y = data.observation(unit).reshape(-1, 21) / unit, data.difference_nT.ravel() / unit
        size = np.linalg.norm(H, axis=0)
        if (size == 0).any() or np.linalg.cond(H / size) > MAX_CONDITION:
            return Status(
                "unobservable",
                "the eddy term cannot be distinguished from A and T_p on this motion: vary the rate and turn about "
                "more axes",
            )
        found = self._minimum(H, y, 1.0 / size)
        status = Status.settled(found.status > 0, f"{found.nfev} evaluations were not enough: raise max_evaluations")
        scale = np.array([unit] * 3 + [1.0] * 18)
        variance = 2.0 * float(found.cost) / (len(y) - 21)
        covariance = np.asarray(variance * np.linalg.inv(H.T @ H) * np.outer(scale, scale), dtype=float)
        told = {"noise_std_nT": float(np.sqrt(variance)) * unit, "evaluations": float(found.nfev)}
        return calibration(self.name, status, found.x * scale, covariance, told)

    def _minimum(self, H: Array, y: Array, scale: Array) -> OptimizeResult:
        """The x (21,) of least |H x - y|, from zero."""
        return least_squares(
            lambda x: H @ x - y,
            np.zeros(21),
            lambda x: H,
            method="lm",
            x_scale=scale,
            ftol=self.tolerance,
            xtol=self.tolerance,
            gtol=self.tolerance,
            max_nfev=self.max_evaluations,
        )
