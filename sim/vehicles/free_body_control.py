"""Tracking control of a free body with thrusters: inverse dynamics, quaternion attitude error, thrust allocation.

With the velocity nu = (v, w) in the body frame, commanded accelerations a_d (linear) and w_d' (angular),

    tau = (M + M_A) nu_c' + [w x p, w x L + v x p] + D |nu| nu - [0, r x R^T z],   T = B^+ tau,

nu_c' = [R^T a_d - w x v, w_d'], (p, L) = (M + M_A) nu, B (6, thrusters) the wrenches of unit thrusts. The number,
places and directions of the thrusters come from the vehicle's MJCF, see `tracking_gains`.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, sin, sqrt

import mujoco
import numpy as np

from scenarios.arrays import Array
from scenarios.kernel_cache import njit
from sim.engine import control_signature
from sim.plant import mass_matrix
from sim.portable_arithmetic import pseudo_inverse
from sim.vehicles.base import STEP_S
from sim.vehicles.fluid import added_mass, drag, righting_arm, wrenches

FEEDBACK = np.array([2.25, 3.0, 0.8, 6.25, 5.0, 4.0, 1.0])
"""Position 1/s^2, velocity 1/s, integral 1/s^3; attitude, rate, integral likewise; limit of linear feedback, m/s^2."""

POWERED, GAINS, ARM, MASS, DRAG, ACTUATORS = 0, 1, 8, 11, 47, 83
COMMAND, ALLOCATION, LIMIT, ROW = 0, 1, 7, 8
"""Layout of the flat gains: 1 with thrust, 0 without; FEEDBACK (7); righting arm r (3), N m; M + M_A (6, 6); drag D per
squared velocity (6, 6); then a ROW for each actuator: command without thrust, N; thrust of a unit wrench (6), zero for
ballast; largest thrust, N."""

INTEGRAL, TARGET, MATRIX, NU, RATE, WRENCH, MEMORY_SIZE = 0, 6, 16, 25, 31, 37, 43
"""Layout of the memory: integrals of position error (ENU) and attitude error (body); commanded quaternion, rate and
derivative of the rate (commanded frame); R_wb; velocity nu and commanded nu' (body); wrench tau (body)."""

AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")


def tracking_gains(model: mujoco.MjModel, powered: bool, ballast_N: Mapping[str, float] | None = None) -> Array:
    """Gains of `follow` for a body with a free joint, flat: a head of ACTUATORS numbers, then a ROW for each actuator.

    ballast_N : name of a ballast actuator -> command without thrust. Every further actuator is a thruster, with the
        smaller end of the actuator's `ctrlrange` as largest thrust, infinite without a range.

    Raises ValueError where the thrusters cannot give a wrench along each of the six axes.
    """
    ballast_N = ballast_N or {}
    thrusters = np.array([model.actuator(i).name not in ballast_N for i in range(model.nu)])
    B = wrenches(model)[:, thrusters]
    _check_axes(B)
    actuators = np.zeros((model.nu, ROW))
    for name, command_N in ballast_N.items():
        actuators[model.actuator(name).id, COMMAND] = command_N
    actuators[thrusters, ALLOCATION:LIMIT] = pseudo_inverse(B)
    ends_N = np.abs(model.actuator_ctrlrange).min(axis=1)
    actuators[:, LIMIT] = np.where(model.actuator_ctrllimited, ends_N, np.inf)
    parts = (
        float(powered),
        FEEDBACK,
        righting_arm(model),
        mass_matrix(model) + added_mass(model),
        drag(model),
        actuators,
    )
    return np.concatenate([np.ravel(part) for part in parts])


def _check_axes(B: Array) -> None:
    """Raise ValueError unless the columns of B (6, thrusters) span all six axes."""
    reach = B @ np.linalg.pinv(B)  # projection on the wrenches that the thrusters can give
    missing = [axis for axis, share in zip(AXES, np.diag(reach), strict=True) if share < 1.0 - 1e-9]
    if missing:
        count = f"{B.shape[1]} thrusters"
        raise ValueError(f"{count} give no independent {', '.join(missing)}: control along all six axes needs six")


@njit(cache=True, nogil=True)
def _target(row, out):  # type: ignore[no-untyped-def]
    """Write the commanded quaternion (4), body rate (3) and angular acceleration (3) of a reference row.

    The row has yaw, pitch, roll (R = Rz Ry Rx) at 9, their first derivatives at 12 and their second at 15.
    """
    cy, cp, cr = cos(0.5 * row[9]), cos(0.5 * row[10]), cos(0.5 * row[11])
    sy, sp, sr = sin(0.5 * row[9]), sin(0.5 * row[10]), sin(0.5 * row[11])
    out[0] = cy * cp * cr + sy * sp * sr
    out[1] = cy * cp * sr - sy * sp * cr
    out[2] = cy * sp * cr + sy * cp * sr
    out[3] = sy * cp * cr - cy * sp * sr
    sp, cp = 2.0 * sp * cp, 1.0 - 2.0 * sp * sp
    sr, cr = 2.0 * sr * cr, 1.0 - 2.0 * sr * sr
    yaw, pitch, roll = row[12], row[13], row[14]
    out[4] = roll - yaw * sp
    out[5] = pitch * cr + yaw * sr * cp
    out[6] = -pitch * sr + yaw * cr * cp
    out[7] = row[17] - row[15] * sp - yaw * pitch * cp
    out[8] = row[16] * cr - pitch * roll * sr + row[15] * sr * cp + yaw * (roll * cr * cp - pitch * sr * sp)
    out[9] = -row[16] * sr - pitch * roll * cr + row[15] * cr * cp - yaw * (roll * sr * cp + pitch * cr * sp)


@njit(cache=True, nogil=True)
def _matrix(w, x, y, z, out):  # type: ignore[no-untyped-def]
    """Rotation matrix of a unit quaternion, row by row (9)."""
    out[0], out[1], out[2] = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
    out[3], out[4], out[5] = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
    out[6], out[7], out[8] = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)


@njit(cache=True, nogil=True)
def _turn(q, w, target, integral, g, scratch, rate):  # type: ignore[no-untyped-def]
    """Write the commanded angular acceleration (rate, 3) and return the attitude error e (3), body frame.

    q_e = q* q_d,  e = 2 sgn(q_e0) (q_e1, q_e2, q_e3),  R_e = R^T R_d (left in scratch, 9),
    w' = R_e w_d' - w x R_e w_d + k e + k_w (R_e w_d - w) + k_i int e.
    """
    a, b, c, d = q[0], -q[1], -q[2], -q[3]
    s, x, y, z = target[0], target[1], target[2], target[3]
    e0 = a * s - b * x - c * y - d * z
    e1 = a * x + b * s + c * z - d * y
    e2 = a * y - b * z + c * s + d * x
    e3 = a * z + b * y - c * x + d * s
    _matrix(e0, e1, e2, e3, scratch)
    sign = 2.0 if e0 >= 0.0 else -2.0
    error = (sign * e1, sign * e2, sign * e3)
    wd = (
        scratch[0] * target[4] + scratch[1] * target[5] + scratch[2] * target[6],
        scratch[3] * target[4] + scratch[4] * target[5] + scratch[5] * target[6],
        scratch[6] * target[4] + scratch[7] * target[5] + scratch[8] * target[6],
    )
    carried = (w[1] * wd[2] - w[2] * wd[1], w[2] * wd[0] - w[0] * wd[2], w[0] * wd[1] - w[1] * wd[0])
    for i in range(3):
        ahead = scratch[3 * i] * target[7] + scratch[3 * i + 1] * target[8] + scratch[3 * i + 2] * target[9]
        feedback = g[3] * error[i] + g[4] * (wd[i] - w[i]) + g[5] * integral[i]
        rate[i] = ahead - carried[i] + feedback
    return error


@njit(cache=True, nogil=True)
def _travel(qpos, qvel, row, integral, g):  # type: ignore[no-untyped-def]
    """Commanded acceleration (ENU): the reference's plus feedback, limited in length; True where not limited."""
    x = g[0] * (row[0] - qpos[0]) + g[1] * (row[3] - qvel[0]) + g[2] * integral[0]
    y = g[0] * (row[1] - qpos[1]) + g[1] * (row[4] - qvel[1]) + g[2] * integral[1]
    z = g[0] * (row[2] - qpos[2]) + g[1] * (row[5] - qvel[2]) + g[2] * integral[2]
    share = min(1.0, g[6] / (sqrt(x * x + y * y + z * z) + 1e-12))
    return row[6] + share * x, row[7] + share * y, row[8] + share * z, share == 1.0


@njit(cache=True, nogil=True)
def _inverse_dynamics(nu, rate, up, gains, wrench):  # type: ignore[no-untyped-def]
    """Wrench for nu' = rate in still water, with the momenta (p, L) = (M + M_A) nu ([Fossen2011] theorem 3.2).

    tau = (M + M_A) nu' + [w x p, w x L + v x p] + D |nu| nu - [0, r x R^T z],  D from the engine's own drag; the
    righting moment r x R^T z of lift and weight acts on the hull without thrust.
    """
    p0 = p1 = p2 = l0 = l1 = l2 = 0.0
    for j in range(6):
        p0 += gains[MASS + j] * nu[j]
        p1 += gains[MASS + 6 + j] * nu[j]
        p2 += gains[MASS + 12 + j] * nu[j]
        l0 += gains[MASS + 18 + j] * nu[j]
        l1 += gains[MASS + 24 + j] * nu[j]
        l2 += gains[MASS + 30 + j] * nu[j]
    v0, v1, v2, w0, w1, w2 = nu[0], nu[1], nu[2], nu[3], nu[4], nu[5]
    r0, r1, r2 = gains[ARM], gains[ARM + 1], gains[ARM + 2]
    wrench[0] = w1 * p2 - w2 * p1
    wrench[1] = w2 * p0 - w0 * p2
    wrench[2] = w0 * p1 - w1 * p0
    wrench[3] = w1 * l2 - w2 * l1 + v1 * p2 - v2 * p1 - (r1 * up[2] - r2 * up[1])
    wrench[4] = w2 * l0 - w0 * l2 + v2 * p0 - v0 * p2 - (r2 * up[0] - r0 * up[2])
    wrench[5] = w0 * l1 - w1 * l0 + v0 * p1 - v1 * p0 - (r0 * up[1] - r1 * up[0])
    for j in range(6):
        square = abs(nu[j]) * nu[j]
        for i in range(6):
            wrench[i] += gains[MASS + 6 * i + j] * rate[j] + gains[DRAG + 6 * i + j] * square


@njit(cache=True, nogil=True)
def _allocate(wrench, actuators, ctrl):  # type: ignore[no-untyped-def]
    """Write T = B^+ tau, all thrusts scaled by a common share to keep every limit; True if the share is 1."""
    share = 1.0
    for k in range(ctrl.size):
        row = ROW * k
        ctrl[k] = 0.0
        for i in range(6):
            ctrl[k] += actuators[row + ALLOCATION + i] * wrench[i]
        if abs(ctrl[k]) > actuators[row + LIMIT]:
            share = min(share, actuators[row + LIMIT] / abs(ctrl[k]))
    if share == 1.0:
        return True
    for k in range(ctrl.size):
        ctrl[k] *= share
    return False


@njit(control_signature, cache=True, nogil=True)
def follow(qpos, qvel, row, gains, memory, ctrl):  # type: ignore[no-untyped-def]
    """One control step: thrusts along the reference row, or the commands without thrust in an unpowered phase."""
    actuators = gains[ACTUATORS:]
    if gains[POWERED] == 0.0:
        for k in range(ctrl.size):
            ctrl[k] = actuators[ROW * k + COMMAND]
        memory[INTEGRAL : INTEGRAL + 6] = 0.0
        return
    g, integral, target = gains[GAINS:ARM], memory[INTEGRAL:TARGET], memory[TARGET:MATRIX]
    matrix, nu, rate, wrench = memory[MATRIX:NU], memory[NU:RATE], memory[RATE:WRENCH], memory[WRENCH:MEMORY_SIZE]
    _target(row, target)
    error = _turn(qpos[3:7], qvel[3:6], target, integral[3:6], g, matrix, rate[3:6])
    _matrix(qpos[3], qpos[4], qpos[5], qpos[6], matrix)
    ax, ay, az, unlimited = _travel(qpos, qvel, row, integral, g)
    for i in range(3):
        nu[i] = matrix[i] * qvel[0] + matrix[3 + i] * qvel[1] + matrix[6 + i] * qvel[2]
        nu[3 + i] = qvel[3 + i]
        rate[i] = matrix[i] * ax + matrix[3 + i] * ay + matrix[6 + i] * az
    # the body frame turns: v' = R^T a - w x v
    rate[0] -= nu[4] * nu[2] - nu[5] * nu[1]
    rate[1] -= nu[5] * nu[0] - nu[3] * nu[2]
    rate[2] -= nu[3] * nu[1] - nu[4] * nu[0]
    _inverse_dynamics(nu, rate, matrix[6:9], gains, wrench)
    # integrals rest while feedback or thrust is limited (anti-windup)
    if _allocate(wrench, actuators, ctrl) and unlimited:
        for i in range(3):
            integral[i] += STEP_S * (row[i] - qpos[i])
            integral[3 + i] += STEP_S * error[i]
