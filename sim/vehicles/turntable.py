"""The three-axis non-magnetic turntable: yaw outside, then pitch, roll inside."""

from __future__ import annotations

from typing import ClassVar, Literal

import mujoco
import numpy as np

from scenarios.arrays import Array
from scenarios.kernel_cache import njit
from scenarios.paths.base import Ability, PhaseBase
from sim.engine import StateLog, control_signature
from sim.rotation import multiply_q, q_from_rotation_vector
from sim.vehicles.base import Kinematics, Vehicle, VehicleTable

BANDWIDTH_RAD_S = 15.0
"""Natural frequency of the critically damped error; at 50 Hz the loop is stable up to 0.83 / 0.02 s = 41 rad/s."""
FRAMES = YAW_FRAME, PITCH_FRAME, PLATFORM = ("yaw_frame", "pitch_frame", "platform")


@njit(cache=True)
def _euler(jx, jy, jz, wx, wy, wz, ax, ay, az):  # type: ignore[no-untyped-def]
    """Moment on a turning frame, J alpha + w x J w, in the axes of the frame."""
    return jx * ax + (jz - jy) * wy * wz, jy * ay + (jx - jz) * wz * wx, jz * az + (jy - jx) * wx * wy


@njit(cache=True)
def inverse_dynamics(qpos, rate, accel, inertia, torque):  # type: ignore[no-untyped-def]
    """Hinge torques for given accelerations of the balanced frames; hinges in the order yaw, pitch, roll.

    Newton-Euler recursion: rates and accelerations from the yaw frame inwards, each in the frame's axes, moments
    J alpha + w x J w back outwards. inertia (9,): diagonals of the yaw frame, pitch frame and platform, kg m^2.
    """
    sp, cp, sr, cr = np.sin(qpos[1]), np.cos(qpos[1]), np.sin(qpos[2]), np.cos(qpos[2])
    w2x, w2y, w2z = -sp * rate[0], rate[1], cp * rate[0]
    a2x, a2y, a2z = -sp * accel[0] - w2z * rate[1], accel[1], cp * accel[0] + w2x * rate[1]
    w3x, w3y, w3z = w2x + rate[2], cr * w2y + sr * w2z, cr * w2z - sr * w2y
    a3x, a3y, a3z = a2x + accel[2], cr * a2y + sr * a2z + w3z * rate[2], cr * a2z - sr * a2y - w3y * rate[2]
    n3x, n3y, n3z = _euler(inertia[6], inertia[7], inertia[8], w3x, w3y, w3z, a3x, a3y, a3z)
    n2x, n2y, n2z = _euler(inertia[3], inertia[4], inertia[5], w2x, w2y, w2z, a2x, a2y, a2z)
    n2x, n2y, n2z = n2x + n3x, n2y + cr * n3y - sr * n3z, n2z + sr * n3y + cr * n3z
    torque[0] = inertia[2] * accel[0] - sp * n2x + cp * n2z
    torque[1] = n2y
    torque[2] = n3x


@njit(control_signature, cache=True)
def control(qpos, qvel, reference, gains, memory, ctrl):  # type: ignore[no-untyped-def]
    """Computed torque: inverse dynamics of u = a_ref + 2 w (v_ref - v) + w^2 (q_ref - q), and the bearings' damping.

    The torque is held for a step, so the reference's acceleration is extrapolated to the middle of the step by the last
    difference. Whole turns in q_ref - q do not count. gains: w, damping (3), inertia (9); memory: a_ref (3), u (3).
    """
    w, accel = gains[0], memory[3:6]
    for i in range(3):
        error = reference[9 + i] - qpos[i]
        error -= 2.0 * np.pi * np.round(error / (2.0 * np.pi))
        ahead = 0.5 * (reference[15 + i] - memory[i])
        memory[i] = reference[15 + i]
        accel[i] = reference[15 + i] + ahead + 2.0 * w * (reference[12 + i] - qvel[i]) + w * w * error
    inverse_dynamics(qpos, qvel, accel, gains[4:13], ctrl)
    for i in range(3):
        ctrl[i] += gains[1 + i] * qvel[i]


class TurntableSpec(VehicleTable):
    """The three-axis non-magnetic turntable: yaw outside, pitch, roll inside."""

    kind: Literal["turntable"]


class Turntable(Vehicle):
    """Three balanced frames on hinges with torque motors; R_wb = Rz(yaw) Ry(pitch) Rx(roll), the position stays zero.

    The motors sit far from the platform: their currents have no effect on the magnetometer.
    """

    name: ClassVar[str] = "turntable"
    table: ClassVar[type[VehicleTable]] = TurntableSpec
    summary: ClassVar[str] = "three-axis non-magnetic turntable of the laboratory: yaw outside, pitch, roll inside"
    noun: ClassVar[str] = "a three-axis turntable"
    abilities: ClassVar[frozenset[Ability]] = frozenset({Ability.POINT, Ability.TILT})
    model_file: ClassVar[str] = "turntable.xml"
    body: ClassVar[str] = PLATFORM
    motors: ClassVar[int] = 0
    memory_size: ClassVar[int] = 6
    tilts_deg: ClassVar[tuple[float, float]] = (180.0, 90.0)
    control = staticmethod(control)

    def place(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Level, heading east, at rest."""
        mujoco.mj_resetData(model, data)

    def gains(self, model: mujoco.MjModel, phase: PhaseBase) -> Array:
        inertia = [model.body(frame).inertia for frame in FRAMES]
        return np.concatenate([[BANDWIDTH_RAD_S], model.dof_damping, *inertia])

    def currents_A(self, ctrl: Array) -> Array:
        return np.zeros((len(ctrl), 0))

    def kinematics(self, model: mujoco.MjModel, log: StateLog) -> Kinematics:
        """From the hinges' angles and rates: with yaw y, pitch p, roll r,

        w = (r' - y' sin p, p' cos r + y' sin r cos p, y' cos r cos p - p' sin r)   (body frame).
        """
        yaw, pitch, roll = (q_from_rotation_vector(log.qpos[:, [i]] * np.eye(3)[2 - i]) for i in range(3))
        still = np.zeros((len(log.qpos), 3))
        return Kinematics(still, multiply_q(multiply_q(yaw, pitch), roll), still, _body_rate(log), still)

    def turns(self, q: Array) -> dict[str, Array]:
        """Outside the platform: the pitch frame with yaw and pitch, the yaw frame with yaw alone."""
        w, x, y, z = q.T
        yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        pitch = np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
        outer = q_from_rotation_vector(yaw[:, None] * np.eye(3)[2])
        middle = multiply_q(outer, q_from_rotation_vector(pitch[:, None] * np.eye(3)[1]))
        return {PLATFORM: q, PITCH_FRAME: middle, YAW_FRAME: outer}


def _body_rate(log: StateLog) -> Array:
    (sp, sr), (cp, cr) = np.sin(log.qpos[:, 1:]).T, np.cos(log.qpos[:, 1:]).T
    yaw, pitch, roll = log.qvel.T
    return np.column_stack([roll - yaw * sp, pitch * cr + yaw * sr * cp, yaw * cr * cp - pitch * sr])
