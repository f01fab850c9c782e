"""Time stamps in a finer unit than the stated second, detected by the rate at which the sensor turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from recordings.units import UNITS
from scenarios.arrays import Array
from validation.policy import POLICY
from validation.signals.direction_rate import median_rate_rad_s
from validation.signals.quaternion_conventions import BASELINE_S, gyro_scale_from_field, match_rates
from validation.text import figure

FINER = ("ms", "us", "ns")


@dataclass(frozen=True)
class Finer:
    """Likely unit of the time stamps, and the field's median rate if the unit were seconds.

    sure : whether a gyro confirms the unit.
    """

    unit: str
    rate_rad_s: float
    sure: bool

    def words(self, column: str) -> str:
        """Return a sentence with the unit and the option to set; `column` is the file's name for the time."""
        do = f"--map time_s={column},unit={self.unit}"
        if self.sure:
            return f"The gyro agrees with the rest of the log only if the time stamps are in {self.unit}: {do}."
        slow = f"The field turns at {figure(self.rate_rad_s)} rad/s in the median, slowly for a vehicle"
        return f"{slow}: if the time stamps are in {self.unit}, say so by {do}."


def finer_unit(time_s: Array, mag_nT: Array, gyro_rad_s: Array | None, att_q: Array | None) -> Finer | None:
    """Return the unit of time stamps (n,) in which a log turns as fast as the gyro, or None for seconds.

    mag_nT, gyro_rad_s (n, 3), att_q (n, 4). Without a gyro the usual rates of vehicles decide.
    """
    if len(time_s) < POLICY.least_rows or float(np.median(np.diff(time_s))) < POLICY.least_interval_s:
        return None
    rate_rad_s = _rate_rad_s(time_s, mag_nT)
    for unit in FINER:
        read_s = UNITS["time"][unit][0] * time_s
        if gyro_rad_s is None:
            fits = POLICY.usual_rad_s[0] < _rate_rad_s(read_s, mag_nT) < POLICY.usual_rad_s[1]
        else:
            fits = _agrees(read_s, mag_nT, gyro_rad_s, att_q)
        if fits:
            return Finer(unit, rate_rad_s, gyro_rad_s is not None)
    return None


def _agrees(time_s: Array, mag_nT: Array, gyro_rad_s: Array, att_q: Array | None) -> bool:
    """Return whether a gyro turns as fast as the attitude, or as the field where there is no attitude."""
    if att_q is None:
        scale, share = gyro_scale_from_field(time_s, mag_nT, gyro_rad_s)
    else:
        match = match_rates(time_s, att_q, gyro_rad_s)
        scale, share = (0.0, 0.0) if match is None else (match.scale, match.share)
    return share > POLICY.least_explained and abs(scale - 1) < POLICY.scale_by_field


def _rate_rad_s(time_s: Array, mag_nT: Array) -> float:
    """Return the median rate of the field's direction in rad/s, 0 for a sensor at rest."""
    u = mag_nT / np.maximum(np.linalg.norm(mag_nT, axis=1, keepdims=True), 1.0)
    long_enough = time_s[-1] - time_s[0] > 2 * BASELINE_S
    turns = long_enough and np.linalg.norm(u.std(axis=0)) >= POLICY.still_spread
    return median_rate_rad_s(u, time_s, BASELINE_S) if turns else 0.0
