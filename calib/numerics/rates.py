"""Body rate and field rate from what a recording has."""

from __future__ import annotations

import numpy as np
from scipy.signal import savgol_filter
from scipy.spatial.transform import Rotation

from recordings import Recording
from scenarios.arrays import Array

SMOOTHING_SAMPLES = 9
"""Window of the cubic Savitzky-Golay derivative."""


def world_to_body(att_q: Array, vector_enu: Array) -> Array:
    """A world vector (3,) in the body frame, R_wb^T v: (n, 3), for attitudes (n, 4) w x y z, body to world."""
    return np.asarray(Rotation.from_quat(att_q, scalar_first=True).inv().apply(vector_enu))


def body_rate(recording: Recording) -> Array | None:
    """Body rate (n, 3), rad/s: the gyro's, else the attitude's central difference, else None."""
    if recording.gyro_rad_s is not None:
        return np.asarray(recording.gyro_rad_s)
    if recording.att_q is None or len(recording) < 2:
        return None
    attitude = Rotation.from_quat(recording.att_q, scalar_first=True)
    step = (attitude[:-1].inv() * attitude[1:]).as_rotvec() / np.diff(recording.time_s)[:, None]
    padded = np.concatenate((step[:1], step, step[-1:]))
    return np.asarray((padded[:-1] + padded[1:]) / 2)


def smoothed_derivative(values: Array, time_s: Array) -> Array:
    """Time derivative (n, 3) of evenly sampled values (n, 3), cubic over nine samples where there are as many."""
    if len(values) < SMOOTHING_SAMPLES:
        return np.asarray(np.gradient(values, time_s, axis=0))
    interval_s = (time_s[-1] - time_s[0]) / (len(time_s) - 1)
    return np.asarray(savgol_filter(values, SMOOTHING_SAMPLES, 3, deriv=1, delta=interval_s, axis=0))
