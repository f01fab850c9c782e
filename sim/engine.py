"""The closed loop over MuJoCo's C functions, in numba and without the interpreter: control, step, log.

A Python loop around `mujoco.mj_step` costs four times the step itself; this one costs a tenth.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import NamedTuple

import llvmlite.binding as llvm
import mujoco
import numpy as np
from numba import types

from scenarios.arrays import Array
from scenarios.kernel_cache import njit
from sim.portable_arithmetic import inverse

LIBRARY = {"linux": "libmujoco.so.*", "darwin": "libmujoco.*.dylib", "win32": "mujoco.dll"}
"""File name of MuJoCo's C library in the Python package, by `sys.platform`."""


def library_file(folder: Path, platform: str = sys.platform) -> Path:
    """MuJoCo's C library in the folder of the Python package; ImportError where none has the platform's name."""
    if platform not in LIBRARY:
        raise ImportError(f"the name of MuJoCo's library is not known for {platform}, only for {', '.join(LIBRARY)}")
    found = sorted(folder.glob(LIBRARY[platform]))
    if not found:
        raise ImportError(f"MuJoCo's library {LIBRARY[platform]} is not in {folder}: install the package mujoco again")
    return found[-1]


llvm.load_library_permanently(str(library_file(Path(mujoco.__file__).parent)))


def _c(name: str, *arguments: types.Type) -> types.ExternalFunction:
    return types.ExternalFunction(name, types.void(*arguments))


def _named(cls: type[tuple[object, ...]], *members: types.Type) -> types.BaseTuple:
    return types.BaseTuple.from_types(members, cls)


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
"""Signature of a controller: (qpos, qvel, reference row, gains, memory, ctrl) -> None; memory and ctrl are written."""
control_signature = "void(float64[::1], float64[::1], float64[::1], float64[::1], float64[::1], float64[::1])"


class Views(NamedTuple):
    """The engine's own arrays; `R_wb` (9) and `wind` are the body's attitude and the medium's velocity, m/s ENU."""

    qpos: Array
    qvel: Array
    qacc: Array
    ctrl: Array
    R_wb: Array
    passive: Array
    bias: Array
    actuator: Array
    applied: Array
    wind: Array


class Scratch(NamedTuple):
    """Work arrays of a step in water: four of the added mass, five of the Runge-Kutta step."""

    relative: Array
    turn: Array
    force: Array
    rate: Array
    first_qpos: Array
    first_qvel: Array
    velocity: Array
    velocity_sum: Array
    accel_sum: Array


class Plant(NamedTuple):
    """A model and the data (addresses), the step, and the added mass M_A (6, 6; empty: none) of the water.

    share = (M + M_A)^-1 (6, 6), M the rigid body's inertia; both in the body frame.
    """

    model: int
    data: int
    step_s: float
    views: Views
    scratch: Scratch
    added: Array
    share: Array


class Stop(NamedTuple):
    """End of a course where sign (z - z_m) > 0, before a row of the log, so the samples stay even; sign 0: no end."""

    z_m: float = 0.0
    sign: float = 0.0


class ReferenceTrack(NamedTuple):
    """Input of the loop: reference (n, 18) and flow (n, 3; m/s ENU) of each step, the controller's gains and memory.

    Every `every`-th step has a row in the log; the course ends at a multiple of `grid` steps.
    """

    reference: Array
    flow: Array
    gains: Array
    memory: Array
    every: int = 1
    stop: Stop = Stop()
    grid: int = 1


class StateLog(NamedTuple):
    """Log of the loop, a row a sample: state, commands, and dqvel/dt over the following step."""

    qpos: Array
    qvel: Array
    ctrl: Array
    accel: Array

    def first(self, rows: int) -> StateLog:
        """The first rows."""
        return StateLog(*(part[:rows] for part in self))


VIEWS = _named(Views, *[VEC] * len(Views._fields))
SCRATCH = _named(Scratch, *[VEC] * len(Scratch._fields))
PLANT = _named(Plant, POINTER, POINTER, types.float64, VIEWS, SCRATCH, MAT, MAT)
STOP = _named(Stop, types.float64, types.float64)
COURSE = _named(ReferenceTrack, MAT, MAT, VEC, VEC, types.int64, STOP, types.int64)
LOG = _named(StateLog, *[MAT] * len(StateLog._fields))


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
    """mj_forward with the added mass: qacc from qpos, qvel and ctrl."""
    _position(plant.model, plant.data)
    _velocity(plant.model, plant.data)
    _actuation(plant.model, plant.data)
    _add_mass(plant)
    _acceleration(plant.model, plant.data)
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
def _step_in_water(plant):  # type: ignore[no-untyped-def]
    """A classical fourth-order Runge-Kutta step, as in mj_step, with the added mass in every stage.

    Body rates of different stages do not commute; mj_step ignores the commutators, and its attitude is of second order
    where the axis of rotation turns. The brackets of [MuntheKaas1999] restore the fourth order: K_i = dt w_i,
    K_2 / 2 + [K_1, K_2] / 8 before stage 3 and + [K_1, K_4] / 12 in the sum (signs for rates in the body).
    """
    dt, qpos, qvel, qacc, scratch = plant.step_s, plant.views.qpos, plant.views.qvel, plant.views.qacc, plant.scratch
    first_qvel, velocity = scratch.first_qvel, scratch.velocity
    velocity_sum, accel_sum = scratch.velocity_sum, scratch.accel_sum
    scratch.first_qpos[:] = qpos
    first_qvel[:] = qvel
    velocity_sum[:] = 0.0
    accel_sum[:] = 0.0
    for stage in range(4):
        _forward(plant)
        weight = 1.0 / 6.0 if stage in (0, 3) else 1.0 / 3.0
        part = dt if stage == 2 else 0.5 * dt
        qpos[:] = scratch.first_qpos
        for j in range(6):
            velocity[j] = qvel[j]
            velocity_sum[j] += weight * velocity[j]
            accel_sum[j] += weight * qacc[j]
            qvel[j] = first_qvel[j] + part * qacc[j]
        if stage == 1:
            _bracket(velocity, first_qvel, 0.25 * dt, velocity)
        if stage < 3:
            _integrate(plant.model, qpos.ctypes.data, velocity.ctypes.data, part)
    _bracket(velocity_sum, first_qvel, dt / 12.0, velocity)
    _integrate(plant.model, qpos.ctypes.data, velocity_sum.ctypes.data, dt)
    for j in range(6):
        qvel[j] = first_qvel[j] + dt * accel_sum[j]


@njit(types.int64(CONTROL, PLANT, COURSE, LOG), cache=True, nogil=True)
def advance(control, plant, course, log):  # type: ignore[no-untyped-def]
    """Run the loop over the rows of the reference, fill the log, and return the number of steps taken.

    The control acts once a step (zero-order hold). Without added mass the step is mj_step.
    """
    qpos, qvel, ctrl, wind = plant.views.qpos, plant.views.qvel, plant.views.ctrl, plant.views.wind
    for i in range(course.reference.shape[0]):
        row = i // course.every
        logged = i == row * course.every
        if logged and i % course.grid == 0 and course.stop.sign * (qpos[2] - course.stop.z_m) > 0.0:
            return i
        wind[:] = course.flow[i]
        control(qpos, qvel, course.reference[i], course.gains, course.memory, ctrl)
        if logged:
            log.qpos[row] = qpos
            log.qvel[row] = qvel
            log.ctrl[row] = ctrl
        if plant.added.size:
            _step_in_water(plant)
        else:
            _step(plant.model, plant.data)
        if logged:
            for j in range(qvel.size):
                log.accel[row, j] = (qvel[j] - log.qvel[row, j]) / plant.step_s
    return course.reference.shape[0]


def plant_of(model: mujoco.MjModel, data: mujoco.MjData, body: str, added: Array) -> Plant:
    """The plant of a model; `body` names the body with the free joint (any body of a model on hinges)."""
    views = Views(
        *(data.qpos, data.qvel, data.qacc, data.ctrl, data.xmat[model.body(body).id]),
        *(data.qfrc_passive, data.qfrc_bias, data.qfrc_actuator, data.qfrc_applied, model.opt.wind),
    )
    scratch = Scratch(*(np.zeros(size) for size in (3, 3, 6, 6, model.nq, model.nv, model.nv, model.nv, model.nv)))
    added = np.ascontiguousarray(added)
    share = inverse(mass_matrix(model) + added) if added.size else added
    return Plant(model._address, data._address, model.opt.timestep, views, scratch, added, share)


def log_of(model: mujoco.MjModel, rows: int) -> StateLog:
    """An empty log with `rows` rows."""
    return StateLog(*(np.empty((rows, width)) for width in (model.nq, model.nv, model.nu, model.nv)))


def mass_matrix(model: mujoco.MjModel) -> Array:
    """Mass matrix M (nv, nv) of the bodies in the first pose; for a free joint about the body's origin, body frame."""
    probe = mujoco.MjData(model)
    mujoco.mj_forward(model, probe)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, probe, mass)
    return mass
