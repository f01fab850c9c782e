"""The engine's Runge-Kutta step over MuJoCo's C functions, with the inertia of the water around a vehicle."""

from __future__ import annotations

from numba import types

from scenarios.kernel_cache import njit
from sim.plant import PLANT, POINTER, VEC


def _c(name: str, *arguments: types.Type) -> types.ExternalFunction:
    return types.ExternalFunction(name, types.void(*arguments))


_step = _c("mj_step", POINTER, POINTER)
_position = _c("mj_fwdPosition", POINTER, POINTER)
_kinematics = _c("mj_kinematics", POINTER, POINTER)
_centres = _c("mj_comPos", POINTER, POINTER)
_inertia = _c("mj_makeM", POINTER, POINTER)
_factors = _c("mj_factorM", POINTER, POINTER)
_transmission = _c("mj_transmission", POINTER, POINTER)
_velocity = _c("mj_fwdVelocity", POINTER, POINTER)
_actuation = _c("mj_fwdActuation", POINTER, POINTER)
_acceleration = _c("mj_fwdAcceleration", POINTER, POINTER)
_constraint = _c("mj_fwdConstraint", POINTER, POINTER)
_integrate = _c("mj_integratePos", POINTER, POINTER, POINTER, types.float64)
_check_position = _c("mj_checkPos", POINTER, POINTER)
_check_velocity = _c("mj_checkVel", POINTER, POINTER)
_check_acceleration = _c("mj_checkAcc", POINTER, POINTER)


@njit(types.void(PLANT), cache=True, nogil=True)
def _add_mass(plant):  # type: ignore[no-untyped-def]
    """Write into `applied` the force of the accelerating water, -M_A dnu_r/dt.

    The fluid model of the engine has the drag and the Coriolis terms of the added mass M_A (6, 6; body frame), not
    the inertia. M is the rigid body's inertia, f the sum of all further forces (body frame), nu_r the velocity
    relative to the water, with a linear part v_r that turns with the body in a steady current:

        (M + M_A) a = f + M_A [w x v_r, 0],   force added = -M_A (a - [w x v_r, 0]),   share = (M + M_A)^-1.
    """
    see, R_wb, added, share = plant.views, plant.views.R_wb, plant.added, plant.share
    relative, turn = plant.scratch.relative, plant.scratch.turn
    force, rate = plant.scratch.force, plant.scratch.rate
    for i in range(3):
        relative[i] = 0.0
        force[i] = 0.0
        force[3 + i] = see.passive[3 + i] + see.actuator[3 + i] - see.bias[3 + i]
        for j in range(3):
            relative[i] += R_wb[3 * j + i] * (see.qvel[j] - see.wind[j])
            force[i] += R_wb[3 * j + i] * (see.passive[j] + see.actuator[j] - see.bias[j])
    turn[0] = see.qvel[4] * relative[2] - see.qvel[5] * relative[1]
    turn[1] = see.qvel[5] * relative[0] - see.qvel[3] * relative[2]
    turn[2] = see.qvel[3] * relative[1] - see.qvel[4] * relative[0]
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
        see.applied[3 + i] = force[3 + i]
        see.applied[i] = R_wb[3 * i] * force[0] + R_wb[3 * i + 1] * force[1] + R_wb[3 * i + 2] * force[2]


@njit(types.void(PLANT), cache=True, nogil=True)
def _forward(plant):  # type: ignore[no-untyped-def]
    """mj_forward with the added mass, without sensors: qacc from qpos, qvel and ctrl.

    For a free model, of mj_fwdPosition and mj_fwdConstraint what acts on one: the same bytes in a fifth less time.
    """
    if plant.free:
        _kinematics(plant.model, plant.data)
        _centres(plant.model, plant.data)
        _inertia(plant.model, plant.data)
        _factors(plant.model, plant.data)
        _transmission(plant.model, plant.data)
    else:
        _position(plant.model, plant.data)
    _velocity(plant.model, plant.data)
    _actuation(plant.model, plant.data)
    if plant.added.size:
        _add_mass(plant)
    _acceleration(plant.model, plant.data)
    if plant.free:
        plant.views.qacc[:] = plant.views.smooth
    else:
        _constraint(plant.model, plant.data)


@njit(types.void(VEC, VEC, types.float64, VEC), cache=True, nogil=True)
def _bracket(velocity, first, share, last):  # type: ignore[no-untyped-def]
    """Add share (w_first x w_last) to the angular part of a velocity (6); `last` may be the velocity itself."""
    x = first[4] * last[5] - first[5] * last[4]
    y = first[5] * last[3] - first[3] * last[5]
    z = first[3] * last[4] - first[4] * last[3]
    velocity[3] += share * x
    velocity[4] += share * y
    velocity[5] += share * z


@njit(types.void(PLANT), cache=True, nogil=True)
def _runge_kutta(plant):  # type: ignore[no-untyped-def]
    """A classical fourth-order Runge-Kutta step, with the added mass in every stage.

    Body rates of a free joint at different stages do not commute. The brackets of [MuntheKaas1999] keep the fourth
    order where the axis of rotation turns: K_i = dt w_i, K_2 / 2 + [K_1, K_2] / 8 before stage 3 and + [K_1, K_4] / 12
    in the sum (signs for rates in the body). mj_step keeps the order by other terms: 1e-9 rad apart after a step.
    """
    dt, qpos, qvel, qacc, scratch = plant.step_s, plant.views.qpos, plant.views.qvel, plant.views.qacc, plant.scratch
    first_qvel, velocity = scratch.first_qvel, scratch.velocity
    velocity_sum, accel_sum = scratch.velocity_sum, scratch.accel_sum
    rotates = qpos.size > qvel.size
    scratch.first_qpos[:] = qpos
    first_qvel[:] = qvel
    velocity_sum[:] = 0.0
    accel_sum[:] = 0.0
    for stage in range(4):
        _forward(plant)
        if stage == 0:
            _check_acceleration(plant.model, plant.data)
        weight = 1.0 / 6.0 if stage in (0, 3) else 1.0 / 3.0
        part = dt if stage == 2 else 0.5 * dt
        qpos[:] = scratch.first_qpos
        for j in range(qvel.size):
            velocity[j] = qvel[j]
            velocity_sum[j] += weight * velocity[j]
            accel_sum[j] += weight * qacc[j]
            qvel[j] = first_qvel[j] + part * qacc[j]
        if rotates and stage == 1:
            _bracket(velocity, first_qvel, 0.25 * dt, velocity)
        if stage < 3:
            _integrate(plant.model, qpos.ctypes.data, velocity.ctypes.data, part)
    if rotates:
        _bracket(velocity_sum, first_qvel, dt / 12.0, velocity)
    _integrate(plant.model, qpos.ctypes.data, velocity_sum.ctypes.data, dt)
    for j in range(qvel.size):
        qvel[j] = first_qvel[j] + dt * accel_sum[j]


@njit(types.void(PLANT), cache=True, nogil=True)
def step(plant):  # type: ignore[no-untyped-def]
    """A step of a free model or of one in water, by Runge-Kutta and without sensors; of all others mj_step."""
    if plant.free or plant.added.size:
        _check_position(plant.model, plant.data)
        _check_velocity(plant.model, plant.data)
        _runge_kutta(plant)
    else:
        _step(plant.model, plant.data)
