"""Levenberg-Marquardt on the 21 parameters of the vector model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from calib.base import Calibrator
from calib.models.vector import VectorData, calibration
from calib.observability import motion_status
from calib.reference import Reference
from calib.result import Calibration, Status
from sim.dataset import Recording

Array = NDArray[np.float64]
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
    min_samples: ClassVar[int] = 21
    tolerance: float = 1e-15
    max_evaluations: int = 100
    attitude_std_rad: float = 3.5e-4

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        data = VectorData.of(recording, reference)
        flat = motion_status(data.field_nT, reference.strength_nT, self.attitude_std_rad)
        if flat is not None:
            return flat
        unit = reference.strength_nT
        H, y = data.observation(unit).reshape(-1, 21) / unit, data.difference_nT.ravel() / unit
        size = np.linalg.norm(H, axis=0)
        if (size == 0).any() or np.linalg.cond(H / size) > MAX_CONDITION:
            return Status(
                "unobservable",
                "the eddy term cannot be told from A and T_p on this motion: vary the rate and turn about more axes",
            )
        found = least_squares(
            lambda x: H @ x - y,
            np.zeros(21),
            lambda x: H,
            method="lm",
            x_scale=1.0 / size,
            ftol=self.tolerance,
            xtol=self.tolerance,
            gtol=self.tolerance,
            max_nfev=self.max_evaluations,
        )
        scale = np.array([unit] * 3 + [1.0] * 18)
        variance = 2.0 * float(found.cost) / (len(y) - 21)
        covariance = np.asarray(variance * np.linalg.inv(H.T @ H) * np.outer(scale, scale), dtype=float)
        enough = found.status > 0
        status = Status.settled(enough, f"{found.nfev} evaluations were not enough: raise max_evaluations")
        extra = {"noise_std_nT": float(np.sqrt(variance)) * unit, "evaluations": float(found.nfev)}
        return calibration(self.name, status, found.x * scale, covariance, extra)
