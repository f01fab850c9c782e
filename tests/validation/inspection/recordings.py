"""Series whose noise, converter and faults are known."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from scenarios.arrays import Array
from validation.inspection.finding import Finding
from validation.inspection.log import RawLog, Series, series_of
from validation.inspection.sensor_data import SensorData, derive

RATE_HZ = 50.0
FIELD_NT = 50_000.0


def turning(samples: int, rate_rad_s: float = 0.4) -> tuple[Array, Array]:
    """Times (n,) and the field (n, 3) in a body that turns about all its axes, at varying rate."""
    time_s = np.arange(samples) / RATE_HZ
    yaw = np.cumsum(rate_rad_s * (1 + 0.5 * np.sin(0.1 * time_s))) / RATE_HZ
    pitch, roll = 0.9 * np.sin(0.23 * time_s), 0.9 * np.sin(0.17 * time_s)
    level = np.cos(yaw) * np.cos(pitch)
    rest = np.sqrt(1 - level**2)
    angle = roll + yaw
    return time_s, FIELD_NT * np.column_stack([level, rest * np.cos(angle), rest * np.sin(angle)])


def still(samples: int) -> tuple[Array, Array]:
    """Times (n,) and a constant field (n, 3)."""
    return np.arange(samples) / RATE_HZ, np.tile([20_013.7, -11_201.2, 38_007.9], (samples, 1))


def rounded(values: Array, step: float) -> Array:
    """Values on a converter's steps; as they are for a step of zero."""
    return step * np.round(values / step) if step else values


@dataclass(frozen=True)
class Motion:
    """A motion whose body rate and attitude follow from the same angles by formulas of their own.

    yaw, pitch, roll are sums of sines; R_wb = Rz(yaw) Ry(pitch) Rx(roll), row by row; the rate follows from their
    analytic derivatives, the quaternion from their halves.
    """

    time_s: Array
    q: Array
    rate_rad_s: Array
    R_wb: Array

    def body(self, world: Array) -> Array:
        """A world vector (3,) in the body frame (n, 3)."""
        return np.einsum("nij,i->nj", self.R_wb, world)


FIELD_ENU_NT = np.array([3000.0, 20_000.0, -43_000.0])
GRAVITY_M_S2 = 9.81


def moved(samples: int = 3000, reach_rad: float = 1.2, rate_hz: float = RATE_HZ) -> Motion:
    """A motion through many attitudes, pitch and roll within `reach_rad`."""
    t = np.arange(samples) / rate_hz
    yaw, yaw_rate = 0.5 * t + 0.6 * np.sin(0.7 * t), 0.5 + 0.42 * np.cos(0.7 * t)
    pitch, pitch_rate = reach_rad * np.sin(0.9 * t), 0.9 * reach_rad * np.cos(0.9 * t)
    roll, roll_rate = reach_rad * np.sin(1.3 * t + 1), 1.3 * reach_rad * np.cos(1.3 * t + 1)
    (cy, cp, cr), (sy, sp, sr) = (np.cos([yaw, pitch, roll]), np.sin([yaw, pitch, roll]))
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    rate = [roll_rate - yaw_rate * sp, pitch_rate * cr + yaw_rate * cp * sr, yaw_rate * cp * cr - pitch_rate * sr]
    (a, b, c), (d, e, f) = (np.cos(np.array([yaw, pitch, roll]) / 2), np.sin(np.array([yaw, pitch, roll]) / 2))
    q = [a * b * c + d * e * f, a * b * f - d * e * c, a * e * c + d * b * f, d * b * c - a * e * f]
    return Motion(t, np.stack(q, axis=1), np.stack(rate, axis=1), np.moveaxis(np.array(rows), 2, 0))


def noise(samples: int, std: float, seed: int = 0) -> Array:
    """White noise (n, 3)."""
    return np.random.default_rng(seed).normal(0, std, (samples, 3))


def log_of(time_s: Array, mag_nT: Array, **columns: Array) -> RawLog:
    """A log of these columns (n,); vectors (n, 3) as gyro, accel, and q (n, 4)."""
    names = {"gyro": [f"gyro_{a}_rad_s" for a in "xyz"], "accel": [f"accel_{a}_m_s2" for a in "xyz"],
             "q": [f"att_q{a}" for a in "wxyz"]}  # fmt: skip
    found = {"time_s": time_s, **dict(zip([f"mag_{a}_nT" for a in "xyz"], mag_nT.T, strict=True))}
    for name, values in columns.items():
        found |= dict(zip(names[name], values.T, strict=True)) if name in names else {name: values}
    return RawLog(Path("log.csv"), found, {}, "")


def series(time_s: Array, mag_nT: Array, **columns: Array) -> Series:
    """The sound rows of such a log."""
    return series_of(log_of(time_s, mag_nT, **columns), None)


def sensor_data(time_s: Array, mag_nT: Array, **columns: Array) -> SensorData:
    """What is derived from such a log."""
    return derive(series(time_s, mag_nT, **columns), None)


def one(findings: list[Finding], name: str) -> Finding:
    """The finding of this name."""
    (found,) = [finding for finding in findings if finding.name == name]
    return found
