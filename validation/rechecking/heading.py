"""Heading error on a level survey, as a linear function of a calibration's change."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from calib import Reference
from recordings import Recording
from scenarios.arrays import Array
from validation.rechecking.change import ChangeEstimate
from validation.rechecking.noise import WeightedCovariances
from validation.rechecking.tails import reach
from validation.scoring.hold_out import LEVEL_TILT_RAD, uniform_attitudes

HEADINGS = 24
"""Headings at which the error is looked at; it varies as the first and second harmonic of the heading."""
DIRECTIONS = 100
"""Directions of the field in the body frame where an error in any attitude is looked for."""
ASSUMED_DIP_DEG = 60.0
"""Dip where neither field vector nor accelerometer tells it: a heading's error is that of the horizontal field."""
STEEPEST_DEG = 88.0
"""Steepest dip at which a heading is spoken of."""
DOWN_G = 5.0
"""Least specific force, m/s^2, that tells the vertical."""


@dataclass(frozen=True, eq=False)
class HeadingErrors:
    """Heading errors (q,) of a change on a level survey, without their signs, deg.

    std_deg (k, q) : standard deviations by models of the noise; weights (k,) of the models.
    """

    error_deg: Array
    std_deg: Array
    weights: Array

    @classmethod
    def of(cls, estimate: ChangeEstimate, spread: WeightedCovariances, columns: Array) -> HeadingErrors:
        """Return the errors by the columns (q, p) of `heading_columns`."""
        variances = np.einsum("qp,kpr,qr->kq", columns, spread.covariances, columns, optimize=True)
        return cls(np.abs(columns @ estimate.values), np.sqrt(variances.clip(0.0)), spread.weights)

    def excluded(self, chance: float) -> float:
        """Return the least error that every heading excludes by a one-sided test with this chance of an error."""
        return float(np.max(self.error_deg + reach(chance, self.std_deg, self.weights)))

    def interval(self, chance: float) -> tuple[float, float, float]:
        """Return the largest error, and the ends of its interval; the chance is that of either side."""
        wide = reach(chance, self.std_deg, self.weights)
        return float(self.error_deg.max()), max(float(np.max(self.error_deg - wide)), 0.0), self.excluded(chance)


def dip_of(corrected: Recording, reference: Reference) -> tuple[float, str]:
    """Return the dip in radians, and from what: the field vector, the accelerometer, or nothing (ASSUMED_DIP_DEG)."""
    if reference.field_enu_nT is not None:
        dip_rad = np.arcsin(-reference.field_enu_nT[2] / np.linalg.norm(reference.field_enu_nT))
        return _limited(float(dip_rad)), "field vector"
    if corrected.accel_m_s2 is not None:
        force = np.linalg.norm(corrected.accel_m_s2, axis=1)
        rows = force > DOWN_G
        if rows.any():
            up = corrected.accel_m_s2[rows] / force[rows, None]
            field = corrected.mag_nT[rows] / np.linalg.norm(corrected.mag_nT[rows], axis=1)[:, None]
            return _limited(-float(np.median(np.arcsin(np.sum(up * field, axis=1).clip(-1, 1))))), "accelerometer"
    return float(np.radians(ASSUMED_DIP_DEG)), f"assumed: {ASSUMED_DIP_DEG:g} deg"


def _limited(dip_rad: float) -> float:
    limit = float(np.radians(STEEPEST_DEG))
    return min(max(dip_rad, -limit), limit)


def heading_columns(estimate: ChangeEstimate, dip_rad: float) -> Array:
    """Return d heading / d values (q, p), deg per nT, on all headings, level and tilted by LEVEL_TILT_RAD.

    e = E h + d + sum k I;  with the true tilt the heading is off by (h x e) . up / H^2, H the horizontal field
    """
    yaw = np.arange(HEADINGS) * 2 * np.pi / HEADINGS
    tilts = [(0.0, 0.0), *((s * LEVEL_TILT_RAD, 0.0) for s in (1, -1)), *((0.0, s * LEVEL_TILT_RAD) for s in (1, -1))]
    turns = [Rotation.from_euler("ZYX", np.column_stack([yaw, 0 * yaw + p, 0 * yaw + r])) for p, r in tilts]
    to_world = Rotation.concatenate(turns)
    field = np.array([0.0, np.cos(dip_rad), -np.sin(dip_rad)])
    across = np.array([-np.cos(dip_rad), 0.0, 0.0]) / np.cos(dip_rad) ** 2
    body_field, gradient = to_world.inv().apply(field), to_world.inv().apply(across)
    columns = estimate.error_columns(body_field)
    return np.asarray(np.degrees(np.einsum("qa,qap->qp", gradient, columns)) / estimate.strength_nT)


def anywhere(estimate: ChangeEstimate, dip_rad: float) -> Array:
    """Return d (error over the horizontal field) / d values (q, 3, p), deg per nT, for fields along DIRECTIONS."""
    to_deg = np.degrees(1.0 / (estimate.strength_nT * np.cos(dip_rad)))
    return np.asarray(to_deg * estimate.error_columns(uniform_attitudes(DIRECTIONS).apply([0.0, 0.0, 1.0])))
