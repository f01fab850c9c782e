"""The linear vector model with eddy currents: known field, its rate, and the observation matrix of 21 parameters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from calib.numerics.rates import body_rate, world_to_body
from calib.reference import Reference
from calib.result import OFFSET_NAMES, Calibration, Status
from recordings import Recording
from scenarios.arrays import Array

SOFT_IRON_NAMES = tuple(f"S_{i}{j}" for i in "xyz" for j in "xyz")
EDDY_NAMES = tuple(f"B_{i}{j}_s" for i in "xyz" for j in "xyz")
NAMES = (*OFFSET_NAMES, *SOFT_IRON_NAMES, *EDDY_NAMES)
IDENTITY = np.concatenate((np.zeros(3), np.eye(3).ravel(), np.zeros(9)))
"""Added to the state x = (T_p, A, B) it gives the named parameters (b, S, B): b = T_p, S = I + A."""


@dataclass(frozen=True)
class VectorData:
    """What the vector model needs of a recording: field_nT T, rate_nT_s dT/dt and difference_nT T_m - T, all (n, 3)."""

    field_nT: Array
    rate_nT_s: Array
    difference_nT: Array

    @classmethod
    def of(cls, recording: Recording, reference: Reference) -> VectorData:
        """T from reference and attitude, T = R_wb^T F, and its rate dT/dt = -omega x T.

        omega is the gyro's, else the attitude's central difference; the attitude is always there, so the measured
        field itself is never differentiated (its iron would leak into B). White gyro noise of std s adds white noise of
        std s |T| to dT/dt: 37 nT/s at 1 mrad/s and 37,000 nT, some nT of measurement for a B of 0.1 s.
        """
        assert recording.att_q is not None
        field_nT = world_to_body(recording.att_q, np.array(reference.field_enu_nT))
        rate_rad_s = body_rate(recording)
        assert rate_rad_s is not None
        return cls(field_nT, -np.cross(rate_rad_s, field_nT), recording.mag_nT - field_nT)

    def observation(self, offset_unit_nT: float = 1.0) -> Array:
        """H (n, 3, 21) of T_m - T = H x, x = (T_p, a11 ... a33, b11 ... b33).

        H = [u I3 | T_3x9 | dT_3x9]: row i of T_3x9 holds T^T in its block; u is the unit of T_p, 1 nT in [Li2017]
        eq. 2 to 4 and 1000 nT in eq. 10.
        """
        H = np.zeros((len(self.field_nT), 3, 21))
        for i in range(3):
            H[:, i, i] = offset_unit_nT
            H[:, i, 3 + 3 * i : 6 + 3 * i] = self.field_nT
            H[:, i, 12 + 3 * i : 15 + 3 * i] = self.rate_nT_s
        return H


def calibration(
    name: str,
    status: Status,
    state: Array,
    covariance: Array | None,
    extra: dict[str, float],
    history: tuple[float, ...] = (),
) -> Calibration:
    """The calibration of a state (21,) in nT, 1 and s with its covariance (21, 21).

    T_m = T + T_p + A T + B dT/dt: offset T_p, S = I + A, eddy term B. [Li2017] eq. 1
    """
    values = state + IDENTITY
    parameters = dict(zip(NAMES, values.tolist(), strict=True)) | extra
    return Calibration(
        name=name,
        status=status,
        offset_nT=values[:3].copy(),
        matrix=np.asarray(np.linalg.inv(values[3:12].reshape(3, 3))),
        eddy_s=values[12:].reshape(3, 3).copy(),
        parameters=parameters,
        covariance=covariance,
        covariance_names=NAMES if covariance is not None else (),
        history=history,
    )
