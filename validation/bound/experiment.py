"""What a calibration is made from: the field along the motion, the sensor's matrix, and the noise."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from scenarios.arrays import Array
from validation.bound.colour import Colour

GYRO_STD_RAD_S = 1e-3
"""White noise of a sample of the body rate, each axis, where nobody says it: that of the standard case, and of an
everyday MEMS gyro."""


@dataclass(frozen=True, eq=False)
class Experiment:
    """A sensor m = S h + b + v along a motion: h (n, 3) in nT, the undisturbed field in the body frame, S (3, 3).

    turns   : (n - 1, 3, 3), takes the field from a sample to the next, h_next = turn h; None if not measured
    step_s  : (n - 1,), time between samples, s
    noise_std_nT, gyro_std_rad_s : standard deviation of white noise on each axis of a sample
    gyro_scale_std : of the gyro's scale, each axis, a fraction
    field_enu_nT : (3,), the field in the world, None where only its strength is known
    colour : what there is beside the white noise, None: nothing
    up (n, 3) : in the body, None where no accelerometer sees it; accel_std_m_s2 : of white noise that lasts as its
    noise and the vehicle's own accelerations do, each axis
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
        """Rms strength of the field."""
        return float(np.sqrt(np.mean(np.sum(self.field_nT**2, axis=1))))

    @property
    def directions(self) -> Array:
        """The field's direction (n, 3) in the body frame."""
        return np.asarray(self.field_nT / np.linalg.norm(self.field_nT, axis=1)[:, None])

    @property
    def rate_rad_s(self) -> Array | None:
        """Body rate (n - 1, 3) of each step; None without turns."""
        if self.turns is None:
            return None
        return np.asarray(-Rotation.from_matrix(self.turns).as_rotvec() / self.step_s[:, None])

    @property
    def field_rate_nT_s(self) -> Array | None:
        """dh/dt = -omega x h (n, 3), the body rate omega the mean of the steps before and after; None without turns."""
        step = self.rate_rad_s
        if step is None:
            return None
        padded = np.concatenate((step[:1], step, step[-1:]))
        return np.asarray(-np.cross((padded[:-1] + padded[1:]) / 2.0, self.field_nT))

    def turned(self, R: Array) -> Experiment:
        """The same motion flown with the body turned by R (3, 3) all the time."""
        turns = None if self.turns is None else R @ self.turns @ R.T
        return replace(self, field_nT=self.field_nT @ R.T, turns=turns, up=None if self.up is None else self.up @ R.T)
