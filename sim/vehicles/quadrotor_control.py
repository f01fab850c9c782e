"""Geometric tracking control of a quadrotor on SO(3), 50 Hz, in numba [Lee2010].

T. Lee, M. Leok, N. H. McClamroch, Geometric tracking control of a quadrotor UAV on SE(3), CDC 2010; here with
integral action against wind, drag fed forward from the commanded velocity, and limits.
"""

from __future__ import annotations

import numpy as np

from scenarios.kernel_cache import njit
from sim.engine import control_signature
from sim.vehicles.base import STEP_S

CONSTANTS = ("mass", "gravity", "jx", "jy", "jz", "arm", "torque_m", "max_thrust", "drag")
"""The controller's constants, in order: kg, m/s^2, kg m^2, rotor arm m, drag torque per thrust m, N, N s^2/m^2."""
MASS, GRAVITY, JX, JY, JZ, ARM, TORQUE_M, MAX_THRUST, DRAG = range(len(CONSTANTS))
INTEGRAL, AHEAD, SLOPE, FORCE, TURN, SIZE = 0, 3, 6, 9, 12, 15
"""Memory: integral of the position error (m/s^2), last feed-forward force and slope, force, last commanded rate."""

K_POSITION, K_VELOCITY, K_INTEGRAL = 6.25, 5.0, 2.5
"""Position loop, 1/s^2, 1/s, 1/s^3: a double pole at 2.5 rad/s with slower integral action."""
K_ATTITUDE, K_RATE = 225.0, 30.0
"""Attitude loop, 1/s^2 and 1/s: a double pole at 15 rad/s, six times the position loop's."""
MAX_CORRECTION_M_S2, MAX_SLOPE_M_S3, MAX_TURN_RAD_S2 = 6.0, 40.0, 60.0
"""Limits of feedback acceleration, force slope and turn; larger slopes are jumps between phases, not fed forward."""
TAN_TILT, LEAST_LIFT, YAW_SHARE = 1.7320508, 0.3, 0.15
"""Commanded tilt at most 60 degrees, lift at least 0.3 of the weight; yaw's share of a rotor's thrust."""


@njit(cache=True)
def _clip(x, limit):  # type: ignore[no-untyped-def]
    return min(max(x, -limit), limit)


@njit(cache=True)
def _force(qpos, qvel, reference, k, memory):  # type: ignore[no-untyped-def]
    """Commanded force (ENU) m (a + g + feedback) + D |v| v and the slope of the feed-forward part; both into memory."""
    v = reference[3:6]
    drag = k[DRAG] * np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    for i in range(3):
        error = reference[i] - qpos[i]
        integral = _clip(memory[INTEGRAL + i] + K_INTEGRAL * STEP_S * error, MAX_CORRECTION_M_S2)
        feedback = _clip(K_POSITION * error + K_VELOCITY * (v[i] - qvel[i]), MAX_CORRECTION_M_S2) + integral
        ahead = k[MASS] * reference[6 + i] + drag * v[i]
        slope = (ahead - memory[AHEAD + i]) / STEP_S
        memory[SLOPE + i] = slope if abs(slope) < k[MASS] * MAX_SLOPE_M_S3 else 0.0
        memory[INTEGRAL + i], memory[AHEAD + i] = integral, ahead
        memory[FORCE + i] = ahead + k[MASS] * feedback
    weight = k[MASS] * k[GRAVITY]
    memory[FORCE + 2] = max(memory[FORCE + 2] + weight, LEAST_LIFT * weight)
    side = np.sqrt(memory[FORCE] ** 2 + memory[FORCE + 1] ** 2)
    if side > TAN_TILT * memory[FORCE + 2]:
        memory[FORCE] *= TAN_TILT * memory[FORCE + 2] / side
        memory[FORCE + 1] *= TAN_TILT * memory[FORCE + 2] / side


@njit(cache=True)
def _cross(a, b):  # type: ignore[no-untyped-def]
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(cache=True)
def _dot(a, b):  # type: ignore[no-untyped-def]
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True)
def _scaled(a, factor):  # type: ignore[no-untyped-def]
    return a[0] * factor, a[1] * factor, a[2] * factor


@njit(cache=True)
def attitude_for(force, yaw):  # type: ignore[no-untyped-def]
    """Columns of the attitude with the z axis along the force and the x axis at the heading `yaw`."""
    c, s = np.cos(yaw), np.sin(yaw)
    b3 = _scaled(force, 1.0 / np.sqrt(_dot(force, force)))
    b1 = c * b3[2], s * b3[2], -s * b3[1] - c * b3[0]
    b1 = _scaled(b1, 1.0 / np.sqrt(_dot(b1, b1)))
    return b1, _cross(b3, b1), b3


@njit(cache=True)
def _turn(b1, b2, b3, force, slope, yaw_rate):  # type: ignore[no-untyped-def]
    """Body rate of the commanded attitude, from the force's slope (pitch, roll) and the yaw rate.

    b3' = Omega x b3 gives p = -b2 . F'/|F|, q = b1 . F'/|F|; psi' = (q b2z + r b3z) / (1 - b1z^2) gives r.
    """
    size = np.sqrt(_dot(force, force))
    q = _dot(b1, slope) / size
    return -_dot(b2, slope) / size, q, (yaw_rate * (1.0 - b1[2] * b1[2]) - q * b2[2]) / b3[2]


@njit(cache=True)
def _columns(q):  # type: ignore[no-untyped-def]
    """Body axes in the world from the quaternion (w, x, y, z)."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    r1 = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)
    r2 = 2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)
    return r1, r2, _cross(r1, r2)


@njit(cache=True)
def mix(thrust, x, y, z, k, ctrl):  # type: ignore[no-untyped-def]
    """Rotor thrusts for a total thrust and a torque; roll and pitch come before lift, lift before yaw."""
    roll, pitch = 0.25 * x / k[ARM], 0.25 * y / k[ARM]
    yaw = _clip(0.25 * z / k[TORQUE_M], YAW_SHARE * k[MAX_THRUST])
    tilt = abs(roll) + abs(pitch)
    if tilt > 0.5 * k[MAX_THRUST]:
        roll, pitch, tilt = 0.5 * k[MAX_THRUST] / tilt * roll, 0.5 * k[MAX_THRUST] / tilt * pitch, 0.5 * k[MAX_THRUST]
    lift = min(max(0.25 * thrust, tilt), k[MAX_THRUST] - tilt)
    yaw = _clip(yaw, min(lift, k[MAX_THRUST] - lift) - tilt)
    ctrl[0] = lift + roll - pitch + yaw
    ctrl[1] = lift + roll + pitch - yaw
    ctrl[2] = lift - roll + pitch + yaw
    ctrl[3] = lift - roll - pitch - yaw


@njit(cache=True)
def _in_body(m, v):  # type: ignore[no-untyped-def]
    """R^T R_d v, m = R_d^T R by rows."""
    return (
        m[0][0] * v[0] + m[1][0] * v[1] + m[2][0] * v[2],
        m[0][1] * v[0] + m[1][1] * v[1] + m[2][1] * v[2],
        m[0][2] * v[0] + m[1][2] * v[1] + m[2][2] * v[2],
    )


@njit(cache=True)
def _torque(rate, m, turn, bend, k):  # type: ignore[no-untyped-def]
    """M = J (-k_R e_R - k_O e_O + R^T R_d alpha_d - O x R^T R_d O_d) + O x J O, [Lee2010] eq. 16."""
    error = m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]
    wanted, bend = _in_body(m, turn), _in_body(m, bend)
    carried = _cross(rate, wanted)
    gyroscopic = _cross(rate, (k[JX] * rate[0], k[JY] * rate[1], k[JZ] * rate[2]))
    x = bend[0] - carried[0] - 0.5 * K_ATTITUDE * error[0] - K_RATE * (rate[0] - wanted[0])
    y = bend[1] - carried[1] - 0.5 * K_ATTITUDE * error[1] - K_RATE * (rate[1] - wanted[1])
    z = bend[2] - carried[2] - 0.5 * K_ATTITUDE * error[2] - K_RATE * (rate[2] - wanted[2])
    return k[JX] * x + gyroscopic[0], k[JY] * y + gyroscopic[1], k[JZ] * z + gyroscopic[2]


@njit(cache=True)
def _difference(turn, memory):  # type: ignore[no-untyped-def]
    """Angular acceleration of the commanded attitude by a backward difference, limited; keeps the rate."""
    x = _clip((turn[0] - memory[TURN]) / STEP_S, MAX_TURN_RAD_S2)
    y = _clip((turn[1] - memory[TURN + 1]) / STEP_S, MAX_TURN_RAD_S2)
    z = _clip((turn[2] - memory[TURN + 2]) / STEP_S, MAX_TURN_RAD_S2)
    memory[TURN], memory[TURN + 1], memory[TURN + 2] = turn
    return x, y, z


@njit(control_signature, cache=True)
def control(qpos, qvel, reference, gains, memory, ctrl):  # type: ignore[no-untyped-def]
    """Rotor thrusts (front left, rear left, rear right, front right; N) for position and yaw.

    f = F . R e3 [Lee2010] eq. 15, M by eq. 16 with e_R = 1/2 vee(R_d^T R - R^T R_d), e_O = O - R^T R_d O_d. The
    reference's pitch and roll are not used: pitch and roll of a quadrotor follow from the acceleration.
    """
    _force(qpos, qvel, reference, gains, memory)
    force = memory[FORCE], memory[FORCE + 1], memory[FORCE + 2]
    slope = memory[SLOPE], memory[SLOPE + 1], memory[SLOPE + 2]
    b1, b2, b3 = attitude_for(force, reference[9])
    turn = _turn(b1, b2, b3, force, slope, reference[12])
    bend = _difference(turn, memory)
    r1, r2, r3 = _columns(qpos[3:7])
    m = (
        (_dot(b1, r1), _dot(b1, r2), _dot(b1, r3)),
        (_dot(b2, r1), _dot(b2, r2), _dot(b2, r3)),
        (_dot(b3, r1), _dot(b3, r2), _dot(b3, r3)),
    )
    x, y, z = _torque((qvel[3], qvel[4], qvel[5]), m, turn, bend, gains)
    mix(_dot(force, r3), x, y, z, gains, ctrl)
