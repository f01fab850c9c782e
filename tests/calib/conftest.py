"""The standard case: motion, field, truth and noise, in the bench's frames (ENU world, FLU body)."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import cache
from types import ModuleType

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib import Reference
from recordings import Recording

FIELD_NED_NT = np.array([12637.48, -11484.12, -32730.72])
FIELD_ENU_NT = (FIELD_NED_NT[1], FIELD_NED_NT[0], -FIELD_NED_NT[2])
FLIP = np.diag([1.0, -1.0, -1.0])
"""Forward-right-down to forward-left-up."""
NED_TO_ENU = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
SOFT = FLIP @ np.array([[1.1198, 0.0120, -0.0154], [0.0120, 1.0097, -0.0090], [-0.0154, -0.0090, 0.9590]]) @ FLIP
HARD_NT = FLIP @ np.array([1200.0, -800.0, 2000.0])
NOISE_STD_NT = 10.0
REFERENCE = Reference.of_vector(FIELD_ENU_NT)
MOTIONS = ("full", "pitch", "auv")


def angles_rad(motion: str, time_s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Yaw, pitch, roll (n,) of a standard motion, body to north-east-down."""
    if motion == "full":
        return (
            0.11 * time_s,
            np.radians(88 * np.sin(0.053 * time_s + 1.1)),
            np.radians(180 * np.sin(0.097 * time_s + 0.3)),
        )
    pitch_deg = {"pitch": 45.0, "auv": 5.0}[motion]
    return (
        np.radians(6.0 * time_s),
        np.radians(pitch_deg * np.sin(2 * np.pi * time_s / 47)),
        np.radians(5 * np.sin(2 * np.pi * time_s / 31)),
    )


def attitude(motion: str, time_s: np.ndarray) -> Rotation:
    """R_wb, FLU body to ENU world, of a standard motion."""
    to_ned = Rotation.from_euler("ZYX", np.column_stack(angles_rad(motion, time_s)))
    return Rotation.from_matrix(NED_TO_ENU) * to_ned * Rotation.from_matrix(FLIP)


def recording(
    motion: str,
    seed: int | None,
    *,
    n: int = 3600,
    soft: np.ndarray = SOFT,
    eddy_s: np.ndarray | None = None,
    noise_std_nT: float = NOISE_STD_NT,
) -> Recording:
    """A recording of a standard motion at 10 Hz; seed None leaves the noise out."""
    time_s = np.arange(n) / 10.0
    att_q, field_nT, rate_rad_s = (values.copy() for values in _moved(motion, n))
    mag_nT = field_nT @ soft.T + HARD_NT
    if eddy_s is not None:
        mag_nT = mag_nT - np.cross(rate_rad_s, field_nT) @ eddy_s.T
    clean = Recording(time_s, mag_nT, gyro_rad_s=rate_rad_s, att_q=att_q)
    return clean if seed is None else noisy(clean, seed, noise_std_nT)


@cache
def _moved(motion: str, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Attitude (n, 4), field (n, 3) and body rate (n, 3) of a standard motion at 10 Hz."""
    time_s = np.arange(n) / 10.0
    turn = attitude(motion, time_s)
    return turn.as_quat(scalar_first=True), turn.inv().apply(FIELD_ENU_NT), body_rate_rad_s(motion, time_s)


def noisy(clean: Recording, seed: int, noise_std_nT: float = NOISE_STD_NT) -> Recording:
    """A recording with white noise on top."""
    noise_nT = np.random.default_rng(seed).normal(0.0, noise_std_nT, clean.mag_nT.shape)
    return replace(clean, mag_nT=clean.mag_nT + noise_nT)


def body_rate_rad_s(motion: str, time_s: np.ndarray, step_s: float = 1e-4) -> np.ndarray:
    """Body rate (n, 3) by a central difference of the attitude."""
    before, after = attitude(motion, time_s - step_s), attitude(motion, time_s + step_s)
    return (before.inv() * after).as_rotvec() / (2 * step_s)


def turned(one: Recording, turn: Rotation) -> Recording:
    """The recording in the axes of a turned body: vectors turned, the attitude by the inverse from the right."""
    attitude = Rotation.from_quat(one.att_q, scalar_first=True) * turn.inv()
    vectors = {"mag_nT": turn.apply(one.mag_nT), "gyro_rad_s": turn.apply(one.gyro_rad_s)}
    return replace(one, **vectors, att_q=attitude.as_quat(scalar_first=True))


def with_accelerometer(one: Recording) -> Recording:
    """A recording of a vehicle that turns on the spot: the specific force by its attitude, as the simulator has it."""
    force_m_s2 = 9.81 * Rotation.from_quat(one.att_q, scalar_first=True).inv().apply([0.0, 0.0, 1.0])
    return replace(one, accel_m_s2=force_m_s2)


def with_currents(one: Recording) -> Recording:
    """A recording with the current of one motor, which makes no field: between 5 and 25 A, in periods of 7 s."""
    return replace(one, current_A=15.0 + 10.0 * np.sin(2 * np.pi * one.time_s[:, None] / 7.0))


def level_turns(n: int, seed: int | None) -> Recording:
    """Yaw alone, exactly level: every measurement lies in a plane."""
    time_s = np.arange(n) / 10.0
    turn = Rotation.from_rotvec(np.outer(0.1 * time_s, [0.0, 0.0, 1.0]))
    mag_nT = turn.inv().apply(FIELD_ENU_NT) @ SOFT.T + HARD_NT
    rate_rad_s = np.tile([0.0, 0.0, 0.1], (n, 1))
    clean = Recording(time_s, mag_nT, gyro_rad_s=rate_rad_s, att_q=turn.as_quat(scalar_first=True))
    return clean if seed is None else noisy(clean, seed)


ARRAY_SOFT = (
    np.eye(3),
    np.array([[1.02, 0.01, -0.02], [0.005, 0.97, 0.015], [-0.01, 0.02, 1.04]]),
    np.array([[0.96, -0.02, 0.01], [0.01, 1.03, 0.02], [0.02, -0.01, 0.99]]),
    np.array([[1.01, 0.02, 0.015], [-0.02, 0.98, -0.01], [0.01, 0.015, 1.05]]),
)


def with_array(one: Recording) -> Recording:
    """A recording with four sensors: the given one, and three that turn and stretch what it measures, noise and all."""
    with np.errstate(invalid="ignore"):
        return replace(one, array_mag_nT=np.array([one.mag_nT @ soft.T for soft in ARRAY_SOFT]))


@pytest.fixture(scope="session")
def standard() -> ModuleType:
    """This module: the standard case for the tests."""
    return sys.modules[__name__]
