"""Guidance of the AUV: inverse dynamics along the reference, attitude error as a quaternion, eight thrusters."""

from __future__ import annotations

from math import cos, sin, sqrt

from numba import njit

from sim.engine import control_signature
from sim.vehicles.base import STEP_S

THRUSTERS = 8

POWERED, BALLAST, GAINS, ARM, MASS, DRAG, ALLOCATION, LIMIT = 0, 1, 3, 10, 13, 49, 85, 133
GAINS_SIZE = 134
"""Where the flat gains hold: powered or not; force of the two ballast actuators; the seven feedback gains (position,
velocity, integral; attitude, rate, integral; largest acceleration that feedback may ask); righting arm (3), N m;
M + M_A (6, 6); drag per unit velocity squared (6, 6); thrusts of a unit wrench (8, 6); largest thrust, N."""

INTEGRAL, TARGET, MATRIX, NU, RATE, WRENCH, MEMORY_SIZE = 0, 6, 16, 25, 31, 37, 43
"""Where the memory holds: integrals of position error (ENU) and attitude error (body); wanted quaternion, rate and
its derivative (own frame); R_wb; velocity nu and wanted derivative (body); wrench (body)."""


@njit(cache=True, nogil=True)
def _target(row, out):  # type: ignore[no-untyped-def]
    """Wanted quaternion (4), body rate (3) and its derivative (3) from yaw, pitch, roll and their derivatives."""
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
    """Write the wanted angular acceleration (rate, 3) and return the attitude error e (3), body frame.

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
    """Wanted acceleration (ENU): the reference's plus feedback, which is limited in length."""
    x = g[0] * (row[0] - qpos[0]) + g[1] * (row[3] - qvel[0]) + g[2] * integral[0]
    y = g[0] * (row[1] - qpos[1]) + g[1] * (row[4] - qvel[1]) + g[2] * integral[1]
    z = g[0] * (row[2] - qpos[2]) + g[1] * (row[5] - qvel[2]) + g[2] * integral[2]
    share = min(1.0, g[6] / (sqrt(x * x + y * y + z * z) + 1e-12))
    return row[6] + share * x, row[7] + share * y, row[8] + share * z, share == 1.0


@njit(cache=True, nogil=True)
def _inverse_dynamics(nu, rate, up, gains, wrench):  # type: ignore[no-untyped-def]
    """Wrench that gives nu' = rate in still water, with the momenta (p, L) = (M + M_A) nu ([Fossen2011] theorem 3.2).

    tau = (M + M_A) nu' + [w x p, w x L + v x p] + D |nu| nu - [0, arm x R^T z],  D from the engine's own drag; the
    righting moment arm x R^T z acts on the hull by itself.
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
def _allocate(wrench, gains, ctrl):  # type: ignore[no-untyped-def]
    """Thrusts by the pseudo-inverse, scaled together where one exceeds its limit; True if none does."""
    largest = 0.0
    for k in range(THRUSTERS):
        ctrl[k] = 0.0
        for i in range(6):
            ctrl[k] += gains[ALLOCATION + 6 * k + i] * wrench[i]
        largest = max(largest, abs(ctrl[k]))
    if largest <= gains[LIMIT]:
        return True
    for k in range(THRUSTERS):
        ctrl[k] *= gains[LIMIT] / largest
    return False


@njit(control_signature, cache=True, nogil=True)
def follow(qpos, qvel, row, gains, memory, ctrl):  # type: ignore[no-untyped-def]
    """One control step: thrusts along the reference row, or ballast and silence in an unpowered phase."""
    if gains[POWERED] == 0.0:
        ctrl[:THRUSTERS] = 0.0
        ctrl[THRUSTERS] = gains[BALLAST]
        ctrl[THRUSTERS + 1] = gains[BALLAST + 1]
        memory[INTEGRAL : INTEGRAL + 6] = 0.0
        return
    g, integral, target = gains[GAINS:ARM], memory[INTEGRAL:TARGET], memory[TARGET:MATRIX]
    matrix, nu, rate, wrench = memory[MATRIX:NU], memory[NU:RATE], memory[RATE:WRENCH], memory[WRENCH:MEMORY_SIZE]
    _target(row, target)
    error = _turn(qpos[3:7], qvel[3:6], target, integral[3:6], g, matrix, rate[3:6])
    _matrix(qpos[3], qpos[4], qpos[5], qpos[6], matrix)
    ax, ay, az, modest = _travel(qpos, qvel, row, integral, g)
    for i in range(3):
        nu[i] = matrix[i] * qvel[0] + matrix[3 + i] * qvel[1] + matrix[6 + i] * qvel[2]
        nu[3 + i] = qvel[3 + i]
        rate[i] = matrix[i] * ax + matrix[3 + i] * ay + matrix[6 + i] * az
    rate[0] -= nu[4] * nu[2] - nu[5] * nu[1]
    rate[1] -= nu[5] * nu[0] - nu[3] * nu[2]
    rate[2] -= nu[3] * nu[1] - nu[4] * nu[0]
    _inverse_dynamics(nu, rate, matrix[6:9], gains, wrench)
    ctrl[THRUSTERS] = 0.0
    ctrl[THRUSTERS + 1] = 0.0
    # integrals rest while feedback or thrust is limited, so that they do not wind up
    if _allocate(wrench, gains, ctrl) and modest:
        for i in range(3):
            integral[i] += STEP_S * (row[i] - qpos[i])
            integral[3 + i] += STEP_S * error[i]
