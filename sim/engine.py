"""The closed loop over MuJoCo's C functions, in numba and without the interpreter: control, step, log.

A Python loop around `mujoco.mj_step` costs four times the step itself; this one costs a tenth.
"""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np
from numba import types

from scenarios.arrays import Array
from scenarios.kernel_cache import njit
from sim.plant import MAT, PLANT, VEC, named_type
from sim.steps import step

CONTROL = types.FunctionType(types.void(VEC, VEC, VEC, VEC, VEC, VEC))
"""Signature of a controller: (qpos, qvel, reference row, gains, memory, ctrl) -> None; memory and ctrl are written."""
control_signature = "void(float64[::1], float64[::1], float64[::1], float64[::1], float64[::1], float64[::1])"


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


STOP = named_type(Stop, types.float64, types.float64)
COURSE = named_type(ReferenceTrack, MAT, MAT, VEC, VEC, types.int64, STOP, types.int64)
LOG = named_type(StateLog, *[MAT] * len(StateLog._fields))


@njit(types.int64(CONTROL, PLANT, COURSE, LOG), cache=True, nogil=True)
def advance(control, plant, course, log):  # type: ignore[no-untyped-def]
    """Run the loop over the rows of the reference, fill the log, and return the number of steps taken.

    The control acts once a step (zero-order hold).
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
        step(plant)
        if logged:
            for j in range(qvel.size):
                log.accel[row, j] = (qvel[j] - log.qvel[row, j]) / plant.step_s
    return course.reference.shape[0]


def log_of(model: mujoco.MjModel, rows: int) -> StateLog:
    """An empty log with `rows` rows."""
    return StateLog(*(np.empty((rows, width)) for width in (model.nq, model.nv, model.nu, model.nv)))
