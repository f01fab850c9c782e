"""Time stamps that are said to be seconds and are in a finer unit, judged by how fast the sensor turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from recordings.units import UNITS
from scenarios.arrays import Array
from validation.signals.direction_rate import median_rate_rad_s
from validation.signals.quaternion_conventions import BASELINE_S, LEAST_ROWS, gyro_scale_from_field, match_rates
from validation.text import figure

FINER = ("ms", "us", "ns")
LEAST_INTERVAL_S = 1.0
"""Below it the stamps are no milliseconds, unless a thousand samples a second were logged."""
LEAST_SHARE, TOLERANCE = 0.5, 0.3
"""Of the gyro's variance, or the field's derivative, what is explained at least; how far the scale may be from 1."""
USUAL_RAD_S = (0.005, 2.0)
"""Rates at which a vehicle's field turns in the median: circles at 1 degree/s have 0.009, a tumbled sensor has 1."""
LEAST_SPREAD = 0.05
"""Spread of the field's direction below which the sensor is at rest, and tells nothing."""


@dataclass(frozen=True)
class Finer:
    """The unit that stamps look like, and the field's median rate if they are seconds; sure where a gyro says so."""

    unit: str
    rate_rad_s: float
    sure: bool

    def words(self, column: str) -> str:
        """What is said of it, and what to do; `column` is the file's name for the time."""
        do = f"--map time_s={column},unit={self.unit}"
        if self.sure:
            return f"The gyro agrees with the rest of the log only if the time stamps are in {self.unit}: {do}."
        slow = f"The field turns at {figure(self.rate_rad_s)} rad/s in the median, slowly for a vehicle"
        return f"{slow}: if the time stamps are in {self.unit}, say so by {do}."


def finer_unit(time_s: Array, mag_nT: Array, gyro_rad_s: Array | None, att_q: Array | None) -> Finer | None:
    """The unit in which a vehicle's log (n,) turns as its gyro says, or else as vehicles do, None if that is seconds.

    mag_nT, gyro_rad_s (n, 3), att_q (n, 4) : with a gyro it alone is asked.
    """
    if len(time_s) < LEAST_ROWS or float(np.median(np.diff(time_s))) < LEAST_INTERVAL_S:
        return None
    rate_rad_s = _rate_rad_s(time_s, mag_nT)
    for unit in FINER:
        read_s = UNITS["time"][unit][0] * time_s
        if gyro_rad_s is None:
            fits = USUAL_RAD_S[0] < _rate_rad_s(read_s, mag_nT) < USUAL_RAD_S[1]
        else:
            fits = _agrees(read_s, mag_nT, gyro_rad_s, att_q)
        if fits:
            return Finer(unit, rate_rad_s, gyro_rad_s is not None)
    return None


def _agrees(time_s: Array, mag_nT: Array, gyro_rad_s: Array, att_q: Array | None) -> bool:
    """Whether a gyro turns as fast as the attitude, or as the field without one."""
    if att_q is None:
        scale, share = gyro_scale_from_field(time_s, mag_nT, gyro_rad_s)
    else:
        match = match_rates(time_s, att_q, gyro_rad_s)
        scale, share = (0.0, 0.0) if match is None else (match.scale, match.share)
    return share > LEAST_SHARE and abs(scale - 1) < TOLERANCE


def _rate_rad_s(time_s: Array, mag_nT: Array) -> float:
    """How fast the field's direction turns in the median, 0 where it hardly does."""
    u = mag_nT / np.maximum(np.linalg.norm(mag_nT, axis=1, keepdims=True), 1.0)
    long_enough = time_s[-1] - time_s[0] > 2 * BASELINE_S
    turns = long_enough and np.linalg.norm(u.std(axis=0)) >= LEAST_SPREAD
    return median_rate_rad_s(u, time_s, BASELINE_S) if turns else 0.0
