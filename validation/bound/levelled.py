"""Fisher information with attitudes linked by a gyro, and an accelerometer for the vertical."""

from __future__ import annotations

import numpy as np

from calib.methods.gyro_accel_ml import GyroAccelMl
from calib.models.levelled import STANDARD_GRAVITY_M_S2
from calib.numerics.chain import chained
from calib.numerics.points import cross_matrices
from scenarios.arrays import Array
from scenarios.errors import InputError
from validation.bound.experiment import Experiment
from validation.bound.information import BIAS, SYMMETRIC, Information, jacobian, only_white, without_last

WORD = "norm+gyro+accel"
OF_ACCELEROMETER = 5
"""The field's inclination, gravity, and the accelerometer's bias."""
GRAVITY_STD_M_S2 = GyroAccelMl.gravity_std_m_s2
"""Standard deviation of gravity, as assumed by the calibrator."""


def norm_gyro_and_accel(known: Experiment) -> Information:
    """Return the information for a known strength, attitudes from a gyro with unknown bias, and a measured vertical.

    x_(i+1) = turn_i x_i + (bias + w_i) step,  x a small rotation of the body; d u = x x u,  d a = g x x up. Inclination
    of the field and bias of the accelerometer are unknown; gravity is known to GRAVITY_STD_M_S2.
    Raises InputError for a recording without turns or attitude, and for coloured noise.
    """
    if known.turns is None or known.up is None:
        what = "there is no attitude or no accelerometer for the vertical"
        raise InputError(what, where=f"--knowledge {WORD}", do="map both, or ask with --knowledge norm+gyro")
    only_white(known)
    scales = known.gyro_scale_std > 0
    unknown = OF_ACCELEROMETER + BIAS * (1 + scales)
    M, J = _measured(known, known.up, unknown)
    information = chained(M, J, known.turns, _drift(known, J.shape[2], scales), known.gyro_std_rad_s * known.step_s)
    first = information.shape[0] - unknown
    information[first + 1, first + 1] += GRAVITY_STD_M_S2**-2
    if scales:
        at = np.arange(first + OF_ACCELEROMETER, first + OF_ACCELEROMETER + BIAS)
        information[at, at] += known.gyro_scale_std**-2
    return Information(without_last(information, unknown), SYMMETRIC)


def _measured(known: Experiment, up: Array, unknown: int) -> tuple[Array, Array]:
    """Return M (n, 6, 3) and J (n, 6, 9 + unknown) of field and specific force, each divided by the noise."""
    own = jacobian(known.field_nT / known.strength_nT, SYMMETRIC)
    first = own.shape[2]
    M, J = np.empty((len(up), 6, 3)), np.zeros((len(up), 6, first + unknown))
    seen = known.matrix * known.strength_nT / known.noise_std_nT
    M[:, :3], J[:, :3, :first] = -seen @ cross_matrices(known.directions), own / known.noise_std_nT
    axis = np.cross(known.directions, up)
    length = np.linalg.norm(axis, axis=1)[:, None]
    axis = np.divide(axis, length, out=np.zeros_like(axis), where=length > 0)
    J[:, :3, first] = np.cross(axis, known.directions) @ seen.T
    M[:, 3:] = -STANDARD_GRAVITY_M_S2 * cross_matrices(up) / known.accel_std_m_s2
    J[:, 3:, first + 1] = up / known.accel_std_m_s2
    J[:, 3:, first + 2 : first + OF_ACCELEROMETER] = np.eye(3) / known.accel_std_m_s2
    return M, J


def _drift(known: Experiment, columns: int, scales: bool) -> Array:
    """Return the rotation (n - 1, 3, columns) of each step by the gyro's unknown scales, if any, and bias."""
    assert known.rate_rad_s is not None
    B = np.zeros((len(known.step_s), 3, columns))
    B[:, :, -BIAS:] = known.step_s[:, None, None] * np.eye(3)
    if scales:
        B[:, :, -2 * BIAS : -BIAS] = known.rate_rad_s[:, None, :] * B[:, :, -BIAS:]
    return B
