"""True heading error of a calibration in level flight, of a sensor that is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from calib import Calibration
from recordings import Recording
from scenarios.arrays import Array

HEADINGS = 36
INSTANTS = 400
"""Samples of the log, evenly spaced, whose currents and temperature the heading error is computed at."""


@dataclass(frozen=True, eq=False)
class LevelTruth:
    """What a sensor measures in level flight on HEADINGS, (n, 3) nT, with the inputs' mean field; forward, left, up.

    soft : S (3, 3). driven_nT : field (n, 3) of currents and temperature at each sample of the log.
    """

    measured_nT: Array
    soft: Array
    driven_nT: Array

    def heading_rms_deg(self, fit: Calibration, recording: Recording, *, turned: bool) -> float:
        """Return the rms heading error over headings and instants of the log.

        turned : the sensor's turn in the body counts; else Q is taken off, Q matrix S closest to I: free by strength.
        Of a planar calibration the mean error is: its offset holds the field that a tilted sensor has of z.
        """
        own = np.sum([term.field(recording) for term in fit.inputs], axis=0) if fit.inputs else 0.0 * self.driven_nT
        left = self.driven_nT - self.driven_nT.mean(axis=0) - own
        left = left[np.linspace(0, len(left) - 1, INSTANTS).astype(int)]
        u, _, vt = np.linalg.svd(fit.matrix @ self.soft)
        turn = vt.T @ u.T if fit.determines_z and not turned else np.eye(3)
        field = (self.measured_nT + left[:, None] - fit.offset_nT) @ fit.matrix.T @ turn.T
        error = np.exp(1j * (np.arctan2(field[..., 1], field[..., 0]) - headings_rad()))
        mean = error.mean() if not turned and not fit.determines_z else 1.0
        return float(np.degrees(np.sqrt(np.mean(np.angle(error / mean) ** 2))))


def headings_rad() -> Array:
    """Return the headings (HEADINGS,): the direction of the horizontal field from forward to the left."""
    return np.asarray(2 * np.pi * np.arange(HEADINGS) / HEADINGS)


def level_field_nT(strength_nT: float, dip_rad: float) -> Array:
    """Return the field (HEADINGS, 3) of level flight, body frame."""
    level, up = strength_nT * np.cos(dip_rad), -strength_nT * np.sin(dip_rad)
    yaw = headings_rad()
    return np.column_stack((level * np.cos(yaw), level * np.sin(yaw), np.full(HEADINGS, up)))
