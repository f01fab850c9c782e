"""Recordings whose heading was computed from the magnetometer that is examined."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from recordings import Recording
from scenarios.arrays import Array
from tests.diagnosis.synthetic import FIELD_ENU_NT, recording

IRON = np.array([[1.05, 0.02, -0.03], [0.01, 0.96, 0.02], [-0.02, 0.01, 1.03]])
OFFSET_NT = np.array([900.0, -600.0, 400.0])


def with_own_compass(
    tilt_error_deg: float, calibration: Array, gain_nT_A: float = 0.0, wander_deg: float = 0.0, seed: int = 3
) -> Recording:
    """Iron before the sensor's noise; roll and pitch a little off, the heading tilt-compensated from a calibration.

    Roll and pitch are off by white noise of a size, and by a slow course as an accelerometer has it that is shaken.
    """
    given, rng = recording(noise_nT=0.0), np.random.default_rng(seed)
    n = len(given)
    mag_nT = given.mag_nT @ IRON.T + OFFSET_NT + rng.normal(scale=50.0, size=(n, 3))
    assert given.current_A is not None
    mag_nT += gain_nT_A * given.current_A[:, :1] * [1.0, -0.5, 0.7]
    assert given.att_q is not None
    angles = Rotation.from_quat(given.att_q[:, [1, 2, 3, 0]]).as_euler("ZYX")
    angles[:, 1:] += np.radians(tilt_error_deg) * rng.normal(size=(n, 2))
    slow = gaussian_filter1d(rng.normal(size=(n, 2)), 120, axis=0)
    angles[:, 1:] += np.radians(wander_deg) * slow / slow.std(axis=0)
    level = Rotation.from_euler("YX", angles[:, 1:]).apply((mag_nT - OFFSET_NT) @ np.linalg.inv(calibration).T)
    angles[:, 0] = np.arctan2(FIELD_ENU_NT[1], FIELD_ENU_NT[0]) - np.arctan2(level[:, 1], level[:, 0])
    made = Rotation.from_euler("ZYX", angles)
    return replace(given, mag_nT=mag_nT, att_q=made.as_quat()[:, [3, 0, 1, 2]])
