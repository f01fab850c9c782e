"""DataFlash logs of recordings, and a simulated flight for tests of the reader."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from dataflash_bytes import DOWN, Log, write_compass

from recordings import Recording
from scenarios.arrays import Array

START_S = 100.0


def write_dataflash(recording: Recording, path: Path) -> None:
    """Write a recording as a log."""
    dataflash_of(recording).write(path)


def dataflash_of(recording: Recording) -> Log:
    """Return a recording as a log without parameters: the field cut to mG, the rest in single precision."""
    log, at_s = Log(), recording.time_s
    write_compass(log, at_s, recording.mag_nT)
    if recording.gyro_rad_s is not None and recording.accel_m_s2 is not None:
        warm = recording.temperature_degC if recording.temperature_degC is not None else 20.0
        log.layout("IMU", "QBfffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,T")
        log.rows("IMU", at_s, 0, *(recording.gyro_rad_s * DOWN).T, *(recording.accel_m_s2 * DOWN).T, warm)
    if recording.att_q is not None:
        log.layout("XKQ", "QBffff", "TimeUS,C,Q1,Q2,Q3,Q4")
        log.rows("XKQ", at_s, 0, *ned_from_enu(recording.att_q).T)
    if recording.pos_enu_m is not None:
        east, north, up = recording.pos_enu_m.T
        log.layout("XKF1", "QBfff", "TimeUS,C,PN,PE,PD")
        log.rows("XKF1", at_s, 0, north, east, -up)
    if recording.current_A is not None:
        log.layout("ESC", "QBf", "TimeUS,Instance,Curr")
        for number, current_A in enumerate(recording.current_A.T):
            log.rows("ESC", at_s, number, current_A)
    return log


def product(p: Array, q: Array) -> Array:
    """Hamilton's product of quaternions w x y z, (..., 4)."""
    a, u, b, v = p[..., :1], p[..., 1:], q[..., :1], q[..., 1:]
    scalar = a * b - np.sum(u * v, axis=-1, keepdims=True)
    return np.concatenate([scalar, a * v + b * u + np.cross(u, v)], axis=-1)


def ned_from_enu(q: Array) -> Array:
    """FRD to NED of FLU to ENU (n, 4): half turns about the diagonal of north and east, and about the nose."""
    return product(product(np.array([0.0, 1.0, 1.0, 0.0]) / np.sqrt(2), q), np.array([0.0, 1.0, 0.0, 0.0]))


def rotated(q: Array, vectors: Array) -> Array:
    """Vectors (n, 3), or one, turned by unit quaternions (n, 4)."""
    pure = np.concatenate([np.zeros((*vectors.shape[:-1], 1)), vectors], axis=-1)
    return product(product(q, pure), q * np.array([1.0, -1.0, -1.0, -1.0]))[..., 1:]


@dataclass(frozen=True)
class Flight:
    """A body that turns about all axes in a uniform field: FLU, ENU, nT, rad/s."""

    time_s: Array
    q: Array
    rate_rad_s: Array
    field_nT: Array
    current_A: Array


FIELD_ENU = np.array([2000.0, 19_000.0, -45_000.0])


def flight(count: int = 400, interval_s: float = 0.1) -> Flight:
    """Yaw, pitch and roll swing at different rates; the rate follows from q* dq/dt = (0, omega / 2)."""
    time_s = START_S + interval_s * np.arange(count)
    step_s = 1e-4
    q, before, after = (_attitude(time_s + shift) for shift in (0.0, -step_s, step_s))
    rate = 2 * product(q * np.array([1.0, -1.0, -1.0, -1.0]), (after - before) / (2 * step_s))[:, 1:]
    inverse = q * np.array([1.0, -1.0, -1.0, -1.0])
    current = 8 + 6 * np.sin(0.9 * time_s)
    return Flight(time_s, q, rate, rotated(inverse, np.tile(FIELD_ENU, (count, 1))), current)


def _attitude(time_s: Array) -> Array:
    yaw, pitch, roll = 0.31 * time_s, 0.7 * np.sin(0.23 * time_s), 0.9 * np.sin(0.37 * time_s + 1)
    about_z, about_y, about_x = (
        np.column_stack([np.cos(angle / 2), *(np.sin(angle / 2) * unit for unit in axis)])
        for angle, axis in zip((yaw, pitch, roll), np.eye(3)[::-1], strict=True)
    )
    return product(product(about_z, about_y), about_x)
