"""Turns of the magnetometer's axes that an accelerometer or an attitude allows: dip and field must be constant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from scenarios.arrays import Array
from validation.axes.evidence import AxisCondition, MapEvidence, evidence
from validation.axes.maps import TURNS
from validation.axes.policy import AXES
from validation.axes.rows import AxisRows, piece_moments, rows_of
from validation.policy import POLICY


@dataclass(frozen=True)
class DirectionEvidence:
    """Evidence of directions, and the field (24, k) along known directions for each turn, over the field's strength.

    along : up (24, 1) for an accelerometer; the first, second and third axis of the world (24, 3) for an attitude.
    """

    evidence: MapEvidence
    along: Array


def accel_evidence(time_s: Array, mag_nT: Array, accel: Array) -> DirectionEvidence | None:
    """Return which turns P satisfy ``(P m - c) . a = d`` with constant c and d; None for too few calm rows.

    accel (n, 3) in any unit; rows whose size is far from the median are left out. N = P + D for soft iron.
    """
    size = np.linalg.norm(accel, axis=1)
    typical = float(np.nanmedian(size)) if np.isfinite(size).any() else 0.0
    if not typical > 0:
        return None
    calm = np.abs(size - typical) < POLICY.calm_share * typical
    rows = rows_of(time_s, mag_nT, np.where(calm[:, None], accel / typical, np.nan), averaged=False)
    if rows is None:
        return None
    error = float(np.sqrt(np.nanmean((size / typical - 1.0) ** 2)))
    up = _directions(rows.other, error)
    if up is None:
        return None
    functions = np.column_stack([(up[:, :, None] * rows.mag[:, None, :]).reshape(-1, 9), up, np.ones(len(up))])
    design = np.broadcast_to(np.eye(13), (len(TURNS), 1, 13, 13))
    found = _compared(rows, functions, np.asarray(design), 1 / 3, max(AXES.least_error, np.sqrt(3) * error))
    return DirectionEvidence(found, -found.fitted[:, 12:])


def _directions(up: Array, error: float) -> Array | None:
    """Return directions of gravity (n, 3): as measured, their mean for a level motion, None if accelerations hide them.

    error : accelerations, seen in the size of the specific force, over gravity.
    """
    tilt = float(np.sqrt(up.var(axis=0).sum()))
    if tilt > AXES.tilt_over_error * error:
        return up
    return np.broadcast_to(up.mean(axis=0), up.shape) if tilt < AXES.level else None


def attitude_evidence(time_s: Array, mag_nT: Array, q: Array) -> DirectionEvidence | None:
    """Return which turns P satisfy ``P m - c = R^T h`` with constant c and h; None for too few rows.

    q (n, 4) : unit quaternions w, x, y, z, body to world.
    """
    rows = rows_of(time_s, mag_nT, q, averaged=False)
    if rows is None:
        return None
    world = Rotation.from_quat(rows.other, scalar_first=True).as_matrix().reshape(-1, 9)
    functions = np.column_stack([rows.mag, np.ones(len(world)), world])
    design = np.zeros((len(TURNS), 3, 13, 15))
    for i in range(3):
        design[:, i, 0:3, 3 * i : 3 * i + 3] = np.eye(3)
        design[:, i, 3, 9 + i] = 1.0
        for j in range(3):
            design[:, i, 4 + 3 * j + i, 12 + j] = 1.0
    found = _compared(rows, functions, design, 1.0, AXES.least_error)
    return DirectionEvidence(found, -found.fitted[:, 12:])


def _compared(rows: AxisRows, functions: Array, design: Array, share: float, error: float) -> MapEvidence:
    """Return the evidence of functions (n, f); `share` of the field's squares is what the condition sees."""
    prior_std = np.full(design.shape[3], np.inf)
    prior_std[:9] = AXES.distortion
    weight = 1.0 / rows.step
    moments = weight * piece_moments(functions, rows.piece)
    signal = share * weight * float((rows.mag**2).sum())
    return evidence(AxisCondition(moments, design, signal, weight * len(rows.mag), prior_std, error))
