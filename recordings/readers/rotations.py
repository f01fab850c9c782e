"""Mountings of a sensor or a board as autopilots number them: body = R sensor, both forward, right, down (FRD)."""

from __future__ import annotations

import math

import numpy as np

from scenarios.arrays import Array

Angles = tuple[float, float, float]
CUSTOM = (100, 101, 102)
"""Numbers of mountings whose angles are parameters of their own."""
_YAWS = (0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0)
_COMMON: tuple[Angles, ...] = (
    *((0, 0, yaw) for yaw in _YAWS),  # 0 .. 7
    *((180, 0, yaw) for yaw in _YAWS[:4]),  # 8 .. 11
    (0, 180, 0),  # 12: roll 180, yaw 180 is the same
    *((180, 0, yaw) for yaw in _YAWS[5:]),  # 13 .. 15
    *((90, 0, yaw) for yaw in _YAWS[:4]),  # 16 .. 19
    *((270, 0, yaw) for yaw in _YAWS[:4]),  # 20 .. 23
    *((0, 90, 0), (0, 270, 0), (0, 180, 90), (0, 180, 270)),  # 24 .. 27
    *((roll, 90, 0) for roll in (90, 180, 270)),  # 28 .. 30
    *((90, 180, 0), (270, 180, 0)),  # 31, 32
    *((roll, 270, 0) for roll in (90, 180, 270)),  # 33 .. 35
    *((90, 180, 90), (90, 0, 270), (90, 68.8, 293.3), (0, 315, 0), (90, 315, 0)),  # 36 .. 40
)
ARDUPILOT, PX4 = "ardupilot", "px4"
ROTATIONS: dict[str, dict[int, Angles]] = {
    ARDUPILOT: dict(enumerate(_COMMON)) | {41: (0, 7, 0), 42: (45, 0, 0), 43: (315, 0, 0)},
    PX4: dict(enumerate(_COMMON)) | {38: (90, 68, 293)},
}
"""By autopilot and number: roll, pitch and yaw, in degrees [ArduPilot: AP_Math/tests/test_rotations.cpp]."""


def board_rotation(number: int, autopilot: str) -> Array:
    """Return R (3, 3) of a mounting by its number, body = R sensor in FRD.

    autopilot : "ardupilot" or "px4", which differ in number 38 and beyond 40.
    Raises ValueError for a number without a mounting, and for CUSTOM, whose angles go to `euler_rotation`.
    """
    angles = ROTATIONS[autopilot].get(number)
    if angles is None:
        raise ValueError(f"{autopilot} has no mounting of number {number}")
    return euler_rotation(*angles)


def euler_rotation(roll_deg: float, pitch_deg: float, yaw_deg: float) -> Array:
    """Return R = Rz(yaw) Ry(pitch) Rx(roll), (3, 3), of angles in degrees: body = R sensor."""
    (cr, sr), (cp, sp), (cy, sy) = map(_cosine_sine, (roll_deg, pitch_deg, yaw_deg))
    return np.array(
        [
            [cp * cy, sr * sp * cy - cr * sy, cr * sp * cy + sr * sy],
            [cp * sy, sr * sp * sy + cr * cy, cr * sp * sy - sr * cy],
            [-sp, sr * cp, cr * cp],
        ]
    )


def _cosine_sine(angle_deg: float) -> tuple[float, float]:
    """Return cos and sin, exact at multiples of 90 degrees."""
    turns, rest_deg = divmod(angle_deg, 90.0)
    c, s = math.cos(math.radians(rest_deg)), math.sin(math.radians(rest_deg))
    return ((c, s), (-s, c), (-c, -s), (s, -c))[int(turns) % 4]
