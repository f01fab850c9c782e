"""The closed loop over MuJoCo's C functions, in numba and without the interpreter: control, step, log.

A Python loop around `mujoco.mj_step` costs four times the step itself; this one costs a tenth.
"""

from __future__ import annotations

from pathlib import Path

import llvmlite.binding as llvm
import mujoco
import numpy as np
from numba import njit, types

from sim.state import Array

llvm.load_library_permanently(str(next(Path(mujoco.__file__).parent.glob("*mujoco.*[0-9]*"))))


# Whoever runs the loop asks the data for warnings; they shall not also go to a file in the working directory.
mujoco.set_mju_user_warning(lambda _: None)


def _c(name: str, *arguments: types.Type) -> types.ExternalFunction:
    return types.ExternalFunction(name, types.void(*arguments))


POINTER = types.intp
_step = _c("mj_step", POINTER, POINTER)
_position = _c("mj_fwdPosition", POINTER, POINTER)
_velocity = _c("mj_fwdVelocity", POINTER, POINTER)
_actuation = _c("mj_fwdActuation", POINTER, POINTER)
_acceleration = _c("mj_fwdAcceleration", POINTER, POINTER)
_constraint = _c("mj_fwdConstraint", POINTER, POINTER)
_integrate = _c("mj_integratePos", POINTER, POINTER, POINTER, types.float64)

VEC = types.float64[::1]
MAT = types.float64[:, ::1]
CONTROL = types.FunctionType(types.void(VEC, VEC, VEC, VEC, VEC, VEC))
"""Signature of a controller: (qpos, qvel, reference row, gains, memory, ctrl) -> None; it writes memory and ctrl."""
control_signature = "void(float64[::1], float64[::1], float64[::1], float64[::1], float64[::1], float64[::1])"

BUFFERS = types.Tuple([VEC] * 11)
"""Views into one model and its data: qpos, qvel, qacc, ctrl, xmat of the body (9), qfrc_passive, qfrc_bias,
qfrc_actuator, qfrc_applied, wind, and scratch for the step."""


@njit(types.void(BUFFERS, MAT, MAT), cache=True, nogil=True)
def _add_mass(buffers, added, share):  # type: ignore[no-untyped-def]
    """Write into qfrc_applied what the accelerating water adds, -M_A dnu_r/dt.

    The fluid model of the engine has the drag and the Coriolis terms of the added mass M_A (6, 6; body frame), not
    its inertia. With M the rigid body's own inertia, f all other forces (body frame), and nu_r the velocity
    relative to the water, whose linear part v_r turns with the body in a steady current:

        (M + M_A) a = f + M_A [w x v_r, 0],   force added = -M_A (a - [w x v_r, 0]),   share = (M + M_A)^-1.
    """
    _, qvel, _, _, xmat, passive, bias, actuator, applied, wind, scratch = buffers
    relative, turn, force, rate = scratch[0:3], scratch[3:6], scratch[6:12], scratch[12:18]
    for i in range(3):
        relative[i] = 0.0
        force[i] = 0.0
        force[3 + i] = passive[3 + i] + actuator[3 + i] - bias[3 + i]
        for j in range(3):
            relative[i] += xmat[3 * j + i] * (qvel[j] - wind[j])
            force[i] += xmat[3 * j + i] * (passive[j] + actuator[j] - bias[j])
    turn[0] = qvel[4] * relative[2] - qvel[5] * relative[1]
    turn[1] = qvel[5] * relative[0] - qvel[3] * relative[2]
    turn[2] = qvel[3] * relative[1] - qvel[4] * relative[0]
    for i in range(6):
        for j in range(3):
            force[i] += added[i, j] * turn[j]
    for i in range(6):
        rate[i] = -turn[i] if i < 3 else 0.0
        for j in range(6):
            rate[i] += share[i, j] * force[j]
    for i in range(6):
        force[i] = 0.0
        for j in range(6):
            force[i] -= added[i, j] * rate[j]
    for i in range(3):
        applied[3 + i] = force[3 + i]
        applied[i] = xmat[3 * i] * force[0] + xmat[3 * i + 1] * force[1] + xmat[3 * i + 2] * force[2]


@njit(types.void(POINTER, POINTER, BUFFERS, MAT, MAT), cache=True, nogil=True)
def _forward(model, data, buffers, added, share):  # type: ignore[no-untyped-def]
    """mj_forward with the added mass: qacc from qpos, qvel and ctrl."""
    _position(model, data)
    _velocity(model, data)
    _actuation(model, data)
    _add_mass(buffers, added, share)
    _acceleration(model, data)
    _constraint(model, data)


@njit(types.void(VEC, VEC, types.float64, VEC), cache=True, nogil=True)
def _bracket(velocity, first, share, last):  # type: ignore[no-untyped-def]
    """Add share (w_first x w_last) to the angular part of a velocity (6); `last` may be that velocity itself."""
    x = first[4] * last[5] - first[5] * last[4]
    y = first[5] * last[3] - first[3] * last[5]
    z = first[3] * last[4] - first[4] * last[3]
    velocity[3] += share * x
    velocity[4] += share * y
    velocity[5] += share * z


@njit(types.void(POINTER, POINTER, types.float64, BUFFERS, MAT, MAT), cache=True, nogil=True)
def _step_in_water(model, data, dt, buffers, added, share):  # type: ignore[no-untyped-def]
    """One classical Runge-Kutta step of fourth order, as mj_step takes it, with the added mass in every stage.

    Body rates of different stages do not commute; mj_step leaves that out, and its attitude is of second order where
    the axis of rotation turns. The brackets of [MuntheKaas1999] restore the fourth order: K_i = dt w_i,
    K_2 / 2 + [K_1, K_2] / 8 before stage 3 and + [K_1, K_4] / 12 in the whole (signs for rates in the body).
    """
    qpos, qvel, qacc, scratch = buffers[0], buffers[1], buffers[2], buffers[10]
    q0, v0, v, v_sum, a_sum = scratch[18:25], scratch[25:31], scratch[31:37], scratch[37:43], scratch[43:49]
    q0[:] = qpos
    v0[:] = qvel
    v_sum[:] = 0.0
    a_sum[:] = 0.0
    for stage in range(4):
        _forward(model, data, buffers, added, share)
        weight = 1.0 / 6.0 if stage in (0, 3) else 1.0 / 3.0
        part = dt if stage == 2 else 0.5 * dt
        qpos[:] = q0
        for j in range(6):
            v[j] = qvel[j]
            v_sum[j] += weight * v[j]
            a_sum[j] += weight * qacc[j]
            qvel[j] = v0[j] + part * qacc[j]
        if stage == 1:
            _bracket(v, v0, 0.25 * dt, v)
        if stage < 3:
            _integrate(model, qpos.ctypes.data, v.ctypes.data, part)
    _bracket(v_sum, v0, dt / 12.0, v)
    _integrate(model, qpos.ctypes.data, v_sum.ctypes.data, dt)
    for j in range(6):
        qvel[j] = v0[j] + dt * a_sum[j]


@njit(
    types.int64(CONTROL, POINTER, POINTER, types.float64, BUFFERS, MAT, MAT, MAT, MAT, VEC, VEC, VEC, types.int64, MAT),
    cache=True,
    nogil=True,
)
def advance(control, model, data, dt, buffers, added, share, reference, flow, gains, memory, stop, every, log):  # type: ignore[no-untyped-def]
    """Run the loop over the rows of `reference`; log a row [qpos, qvel, ctrl, dqvel/dt] at each `every`-th step.

    The control acts once a step (zero-order hold); flow (n, 3) is the wind or current of each step, m/s, ENU.
    stop = (z_m, sign): ends where sign (qpos[2] - z_m) > 0, before a row of the log, so that samples stay evenly
    spaced; sign 0: never. `added` empty: mj_step itself.
    Returns the number of steps taken.
    """
    qpos, qvel, ctrl, wind = buffers[0], buffers[1], buffers[3], buffers[9]
    nq, nv, nu = qpos.size, qvel.size, ctrl.size
    for i in range(reference.shape[0]):
        logged = i % every == 0
        if logged and stop[1] * (qpos[2] - stop[0]) > 0.0:
            return i
        wind[:] = flow[i]
        control(qpos, qvel, reference[i], gains, memory, ctrl)
        if logged:
            row = log[i // every]
            row[:nq] = qpos
            row[nq : nq + nv] = qvel
            row[nq + nv : nq + nv + nu] = ctrl
        if added.size:
            _step_in_water(model, data, dt, buffers, added, share)
        else:
            _step(model, data)
        if logged:
            for j in range(nv):
                row[nq + nv + nu + j] = (qvel[j] - row[nq + j]) / dt
    return reference.shape[0]


def buffers_of(model: mujoco.MjModel, data: mujoco.MjData, body: int) -> tuple[Array, ...]:
    """The views that the loop works on; `body` is the one with the free joint (any, for the turntable)."""
    return (
        *(data.qpos, data.qvel, data.qacc, data.ctrl, data.xmat[body]),
        *(data.qfrc_passive, data.qfrc_bias, data.qfrc_actuator, data.qfrc_applied, model.opt.wind),
        np.zeros(49),
    )


def mass_matrix(model: mujoco.MjModel) -> Array:
    """The bodies' own M (nv, nv) in the first pose; of a free joint there: about the body's origin, in its frame."""
    probe = mujoco.MjData(model)
    mujoco.mj_forward(model, probe)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, probe, mass)
    return mass
