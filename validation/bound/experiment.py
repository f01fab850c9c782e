"""Experiment behind a calibration: field along the motion, matrix of the sensor, and noise."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from scenarios.arrays import Array
from validation.bound.colour import Colour

GYRO_STD_RAD_S = 1e-3
"""Default white noise of a sample of the body rate, each axis: a common MEMS gyro, and the standard case."""


@dataclass(frozen=True, eq=False)
class Experiment:
    """Sensor ``m = S h + b + v`` along a motion: h (n, 3) in nT, the undisturbed field in the body frame, S (3, 3).

    turns   : (n - 1, 3, 3), rotation of the field between samples, h_next = turn h; None if not measured
    step_s  : (n - 1,), time between samples, s
    noise_std_nT, gyro_std_rad_s : standard deviation of white noise on each axis of a sample
    gyro_scale_std : standard deviation of the gyro's scale, each axis, a fraction
    field_enu_nT : (3,), the field in the world, None where only the strength is known
    colour : coloured noise in addition to the white noise, None without
    up : (n, 3), the vertical in the body frame, None without accelerometer
    accel_std_m_s2 : white noise of each axis with as much effect as the accelerometer's noise and the vehicle's
    accelerations
    """

    field_nT: Array
    matrix: Array
    noise_std_nT: float
    turns: Array | None
    step_s: Array
    gyro_std_rad_s: float = GYRO_STD_RAD_S
    field_enu_nT: Array | None = None
    colour: Colour | None = None
    gyro_scale_std: float = 0.0
    up: Array | None = None
    accel_std_m_s2: float = 1.0

    @property
    def strength_nT(self) -> float:
        """Return the rms strength of the field."""
        return float(np.sqrt(np.mean(np.sum(self.field_nT**2, axis=1))))

    @property
    def directions(self) -> Array:
        """Return the field's direction (n, 3) in the body frame."""
        return np.asarray(self.field_nT / np.linalg.norm(self.field_nT, axis=1)[:, None])

    @property
    def rate_rad_s(self) -> Array | None:
        """Return the body rate (n - 1, 3) of each step, None without turns."""
        if self.turns is None:
            return None
        return np.asarray(-Rotation.from_matrix(self.turns).as_rotvec() / self.step_s[:, None])

    @property
    def field_rate_nT_s(self) -> Array | None:
        """Return ``dh/dt = -omega x h`` (n, 3), omega the mean rate of adjacent steps; None without turns."""
        step = self.rate_rad_s
        if step is None:
            return None
        padded = np.concatenate((step[:1], step, step[-1:]))
        return np.asarray(-np.cross((padded[:-1] + padded[1:]) / 2.0, self.field_nT))

    def turned(self, R: Array) -> Experiment:
        """Return the experiment with the body turned by R (3, 3) throughout."""
        turns = None if self.turns is None else R @ self.turns @ R.T
        return replace(self, field_nT=self.field_nT @ R.T, turns=turns, up=None if self.up is None else self.up @ R.T)
