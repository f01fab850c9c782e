"""Motions of simulated logs, by numpy alone: attitudes, rates, and directions of a field in the body frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scenarios.arrays import Array

GRAVITY_M_S2 = 9.81
LARGEST_HOLE_DEG = 35.0
"""Radius of the largest hole in the directions of a sound log."""


@dataclass(frozen=True)
class Course:
    """Times (n,) s, rotations world to body (n, 3, 3), and body rates (n, 3) rad/s."""

    time_s: Array
    R_bw: Array
    rate_rad_s: Array

    def seen(self, world: Array) -> Array:
        """Return a world vector (3,) in the body frame (n, 3)."""
        return np.asarray(self.R_bw @ world)


def tumbling(rng: np.random.Generator, rows: int, rate_hz: float) -> Course:
    """Return a tumble about a slowly wandering axis."""
    slow = np.array([_wander(rng, rows, 6.0 * rate_hz) for _ in range(3)]).T
    rate = rng.uniform(0.7, 1.2) * slow / np.linalg.norm(slow, axis=1, keepdims=True)
    return _course(rate, rate_hz, _turned(rng.normal(size=3)))


def rocking(rng: np.random.Generator, rows: int, rate_hz: float, tilt_deg: float) -> Course:
    """Return turns about the vertical with roll and pitch below a tilt: half of the sphere at most."""
    time_s = np.arange(rows) / rate_hz
    tilt = np.radians(tilt_deg)
    roll = tilt * np.sin(0.61 * time_s + rng.uniform(0, 6))
    pitch = tilt * np.sin(0.43 * time_s + rng.uniform(0, 6))
    yaw = 0.35 * time_s + rng.uniform(0, 6)
    R_wb = _about(2, yaw) @ _about(1, pitch) @ _about(0, roll)
    R_bw = np.swapaxes(R_wb, 1, 2)
    step = np.einsum("nij,nkj->nik", R_bw[:-1], R_bw[1:])
    small = np.stack([step[:, 2, 1], step[:, 0, 2], step[:, 1, 0]], axis=1) * rate_hz
    return Course(time_s, R_bw, np.vstack([small, small[-1:]]))


def largest_hole_deg(directions: Array) -> float:
    """Return the radius of the largest empty circle on the sphere among unit vectors (n, 3)."""
    k = np.arange(400) + 0.5
    lift, turn = 1 - k / 200, np.pi * (1 + 5**0.5) * k
    level = np.sqrt(1 - lift**2)
    places = np.column_stack([level * np.cos(turn), level * np.sin(turn), lift])
    nearest = (places @ directions[:: max(1, len(directions) // 1000)].T).max(axis=1)
    return float(np.degrees(np.arccos(np.clip(nearest.min(), -1, 1))))


def _course(rate: Array, rate_hz: float, start: Array) -> Course:
    R_bw, now = np.empty((len(rate), 3, 3)), start
    for i, omega in enumerate(rate):
        R_bw[i] = now
        now = _turned(-omega / rate_hz) @ now
    return Course(np.arange(len(rate)) / rate_hz, R_bw, rate)


def _wander(rng: np.random.Generator, rows: int, length: float) -> Array:
    """Return a smooth random course (n,) with a correlation of `length` rows."""
    knots = int(rows / length) + 6
    return np.asarray(np.convolve(np.repeat(rng.normal(size=knots), int(length)), _bell(length), "same")[:rows] + 1e-6)


def _bell(length: float) -> Array:
    t = np.linspace(-2, 2, int(2 * length) | 1)
    return np.asarray(np.exp(-(t**2)) / np.exp(-(t**2)).sum())


def _turned(vector: Array) -> Array:
    """Return the rotation (3, 3) by a rotation vector: Rodrigues' formula."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector / max(angle, 1e-12)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K)


def _about(axis: int, angle: Array) -> Array:
    """Return rotations (n, 3, 3) about a coordinate axis."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R = np.tile(np.eye(3), (len(angle), 1, 1))
    R[:, i, i] = R[:, j, j] = np.cos(angle)
    R[:, i, j], R[:, j, i] = -np.sin(angle), np.sin(angle)
    return R
