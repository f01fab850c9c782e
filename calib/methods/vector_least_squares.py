"""Vector least squares: twelve parameters from known attitude and field vector."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from calib.base import Calibrator
from calib.models.vector import EDDY_NAMES, SOFT_IRON_NAMES
from calib.numerics.rates import body_rate, world_to_body
from calib.reference import Reference
from calib.result import OFFSET_NAMES, Calibration, Status
from recordings import Recording
from scenarios.arrays import Array

MAX_CONDITION = 1e9


@dataclass(frozen=True)
class VectorLeastSquares(Calibrator):
    """S, b and on request B by linear least squares on the known field in the body frame.

    m = S h + b + B dh/dt,  h = R_wb^T F,  dh/dt = -omega x h

    F the reference vector (ENU), R_wb and omega the recording's attitude and body rate (the attitude's derivative where
    there is no gyro). White noise, equal on the axes: estimate of least variance. [Li2017] eq. 1 with S = I + A. The
    condition number of the scaled columns is reported; motion smaller than five times `attitude_std_rad` is no
    excitation, since the attitude's own errors would pass for it.
    """

    name: ClassVar[str] = "vector_least_squares"
    summary: ClassVar[str] = "12 linear parameters (21 with eddy currents) from attitude and field vector"
    needs: ClassVar[tuple[str, ...]] = ("attitude", "field_vector")
    min_samples: ClassVar[int] = 5
    eddy: bool = False

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        assert recording.att_q is not None
        h_nT = world_to_body(recording.att_q, np.array(reference.field_enu_nT))
        columns, scale = self._columns(recording, h_nT, reference.strength_nT)
        u, singular, vt = np.linalg.svd(columns, full_matrices=False)
        if singular[0] > MAX_CONDITION * singular[-1]:
            return Status("unobservable", self._collinear_text())
        inverse = (vt.T / singular) / scale[:, None]
        solution = inverse @ (u.T @ recording.mag_nT)
        residual = recording.mag_nT - columns @ (solution * scale[:, None])
        variance_nT2 = float((residual**2).sum()) / (3 * (len(h_nT) - len(solution)))
        return self._calibration(solution, variance_nT2 * inverse @ inverse.T, variance_nT2, singular[0] / singular[-1])

    def _columns(self, recording: Recording, h_nT: Array, strength_nT: float) -> tuple[Array, Array]:
        """Scaled columns (n, p), and the scale (p,) that each was divided by: h, 1 and with eddy dh/dt."""
        parts, scale = [h_nT / strength_nT, np.ones((len(h_nT), 1))], [strength_nT] * 3 + [1.0]
        if self.eddy:
            rate_rad_s = body_rate(recording)
            assert rate_rad_s is not None
            h_rate = -np.cross(rate_rad_s, h_nT)
            size = float(np.sqrt((h_rate**2).sum(axis=1).mean())) or 1.0
            parts.append(h_rate / size)
            scale += [size] * 3
        return np.concatenate(parts, axis=1), np.array(scale)

    def _collinear_text(self) -> str:
        if self.eddy:
            return (
                "the eddy term cannot be distinguished from S: at a constant rate about one axis dh/dt is a fixed "
                "matrix times h; vary the rate and turn about more axes"
            )
        return "the columns of h are not independent; turn about more axes"

    def _calibration(self, solution: Array, column_nT2: Array, variance_nT2: float, condition: float) -> Calibration:
        """Sort the solution (p, 3), one column an axis, into b, S (row by row) and B, and the covariance likewise."""
        p = len(solution)
        blocks = (range(3, 4), range(0, 3), range(4, p))
        order = [row * 3 + axis for rows in blocks for axis in range(3) for row in rows]
        names = (*OFFSET_NAMES, *SOFT_IRON_NAMES, *(EDDY_NAMES if self.eddy else ()))
        values = solution.reshape(3 * p)[order]
        covariance = np.asarray(np.kron(column_nT2, np.eye(3))[np.ix_(order, order)])
        parameters = dict(zip(names, values.tolist(), strict=True)) | {
            "noise_std_nT": float(np.sqrt(variance_nT2)),
            "condition_number": float(condition),
        }
        return Calibration(
            name=self.name,
            status=Status("ok"),
            offset_nT=solution[3].copy(),
            matrix=np.asarray(np.linalg.inv(solution[:3].T)),
            eddy_s=solution[4:7].T.copy() if self.eddy else None,
            parameters=parameters,
            covariance=covariance,
            covariance_names=names,
        )
