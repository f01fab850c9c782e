"""Body rate and field rate from what a recording has."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from recordings import Recording
from scenarios.arrays import Array
from scenarios.kernel_cache import njit

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
    return np.asarray(_central_rate(np.ascontiguousarray(recording.att_q), np.diff(recording.time_s)))


@njit(cache=True, error_model="numpy")
def _central_rate(q: Array, interval_s: Array) -> Array:
    """Mean (n, 3) of the rates of turn before and after each attitude (n, 4); that beside it at either end."""
    out = np.zeros((len(q), 3))
    last = len(q) - 1
    for i in range(last):
        x, y, z = _turn(q[i], q[i + 1])
        x, y, z = x / interval_s[i], y / interval_s[i], z / interval_s[i]
        for k, share in ((i, 1.0 if i == 0 else 0.5), (i + 1, 1.0 if i + 1 == last else 0.5)):
            out[k, 0], out[k, 1], out[k, 2] = out[k, 0] + share * x, out[k, 1] + share * y, out[k, 2] + share * z
    return out


@njit(cache=True, error_model="numpy")
def _turn(p: Array, q: Array) -> tuple[float, float, float]:
    """Rotation vector, rad, of the shorter turn p^-1 q from an attitude p (4,) to q (4,), of any length."""
    w = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3]
    x = p[0] * q[1] - p[1] * q[0] - p[2] * q[3] + p[3] * q[2]
    y = p[0] * q[2] + p[1] * q[3] - p[2] * q[0] - p[3] * q[1]
    z = p[0] * q[3] - p[1] * q[2] + p[2] * q[1] - p[3] * q[0]
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    sine = np.sqrt(x * x + y * y + z * z)
    factor = 2.0 * np.arctan2(sine, w) / sine if sine > 0.0 else 0.0
    return factor * x, factor * y, factor * z


def smoothed_derivative(values: Array, time_s: Array) -> Array:
    """Time derivative (n, 3) of evenly sampled values (n, 3), cubic over nine samples where there are as many."""
    if len(values) < SMOOTHING_SAMPLES:
        return np.asarray(np.gradient(values, time_s, axis=0))
    from scipy.signal import savgol_filter  # half a second of imports, for logs that vary their field alone

    interval_s = (time_s[-1] - time_s[0]) / (len(time_s) - 1)
    return np.asarray(savgol_filter(values, SMOOTHING_SAMPLES, 3, deriv=1, delta=interval_s, axis=0))
