"""Motion of a recording: recorded inputs of effects, interpolated attitude, and the body rate with the least noise."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from calib.numerics.rates import body_rate
from diagnosis.policy import Policy
from diagnosis.problem.linear import sample_noise
from recordings import Recording
from recordings.assemble import scalars_of
from recordings.channels import current_name
from scenarios.arrays import Array


def measured(recording: Recording) -> frozenset[str]:
    """Inputs of effects that a recording holds."""
    present = {
        "attitude": recording.att_q is not None,
        "rate": recording.gyro_rad_s is not None or recording.att_q is not None,
        "position": recording.pos_enu_m is not None,
    }
    motors = {current_name(1)} if recording.motors else set()  # to an effect of the currents any motor will do
    return frozenset(name for name, there in present.items() if there) | motors | frozenset(scalars_of(recording))


def attitude_course(time_s: Array, q: Array) -> CubicSpline:
    """Quaternions (n, 4) as a cubic spline of time, with signs made continuous."""
    signs = np.cumprod(np.where((q[1:] * q[:-1]).sum(axis=1) < 0, -1.0, 1.0))
    return CubicSpline(time_s, q * np.concatenate([[1.0], signs])[:, None])


def attitude_at(course: CubicSpline, time_s: Array) -> Array:
    """Quaternions (n, 4) of a spline at given times, constant after the last knot."""
    q = course(np.minimum(time_s, course.x[-1]))
    return np.ascontiguousarray(q / np.linalg.norm(q, axis=1, keepdims=True))


def moved_attitude(recording: Recording, lead_s: float) -> tuple[Recording, NDArray[np.bool_]]:
    """A recording with the attitude logged a lead later, and the rows (n,) whose attitude was never logged."""
    if not lead_s or recording.att_q is None:
        return recording, np.zeros(len(recording), np.bool_)
    then_s = recording.time_s + lead_s
    q = attitude_at(attitude_course(recording.time_s, recording.att_q), then_s)
    return replace(recording, att_q=q), np.asarray(then_s > recording.time_s[-1])


def course(recording: Recording) -> dict[str, Any]:
    """Fields of the state copied from a recording; zero where not measured."""
    n = len(recording)
    time_s = recording.time_s - recording.time_s[0]
    zero = np.zeros((n, 3))
    return {
        "time_s": time_s,
        "interval_s": float(np.median(np.diff(time_s))),  # of what was sampled, not of gaps and bursts
        "pos_enu_m": zero if recording.pos_enu_m is None else recording.pos_enu_m,
        "channels": scalars_of(recording),
        "attitude": "navigation",
    }


def quieter_rate(recording: Recording, policy: Policy) -> Array:
    """Body rate (n, 3): gyroscope or derivative of a non-repeating attitude, whichever has less noise."""
    derived = body_rate(replace(recording, gyro_rad_s=None))
    assert derived is not None
    gyro, q = recording.gyro_rad_s, recording.att_q
    assert q is not None
    if gyro is None:
        return derived
    repeated = np.mean((np.diff(q, axis=0) == 0).all(axis=1))
    quieter = sample_noise(gyro).sum() < sample_noise(derived).sum()
    return gyro if repeated > policy.little or quieter else derived
