"""A model in MuJoCo's C library as compiled code sees it: addresses, the engine's arrays, work arrays, added mass."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import NamedTuple

import llvmlite.binding as llvm
import mujoco
import numpy as np
from numba import types

from scenarios.arrays import Array
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


def named_type(cls: type[tuple[object, ...]], *members: types.Type) -> types.BaseTuple:
    return types.BaseTuple.from_types(members, cls)


POINTER = types.intp
VEC = types.float64[::1]
MAT = types.float64[:, ::1]


class Views(NamedTuple):
    """The engine's own arrays: `R_wb` (9) the body's attitude, `smooth` qacc without constraints, `wind` in m/s ENU."""

    qpos: Array
    qvel: Array
    qacc: Array
    ctrl: Array
    R_wb: Array
    smooth: Array
    passive: Array
    bias: Array
    actuator: Array
    applied: Array
    wind: Array


class Scratch(NamedTuple):
    """Work arrays of a step: four of the added mass, five of the Runge-Kutta step."""

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

    share = (M + M_A)^-1 (6, 6), M the rigid body's inertia; both in the body frame. free: see `is_free`.
    """

    model: int
    data: int
    step_s: float
    views: Views
    scratch: Scratch
    added: Array
    share: Array
    free: bool


VIEWS = named_type(Views, *[VEC] * len(Views._fields))
SCRATCH = named_type(Scratch, *[VEC] * len(Scratch._fields))
PLANT = named_type(Plant, POINTER, POINTER, types.float64, VIEWS, SCRATCH, MAT, MAT, types.boolean)


def plant_of(model: mujoco.MjModel, data: mujoco.MjData, body: str, added: Array) -> Plant:
    """The plant of a model; `body` names the body with the free joint (any body of a model on hinges)."""
    views = Views(
        *(data.qpos, data.qvel, data.qacc, data.ctrl, data.xmat[model.body(body).id]),
        *(data.qacc_smooth, data.qfrc_passive, data.qfrc_bias, data.qfrc_actuator, data.qfrc_applied, model.opt.wind),
    )
    scratch = Scratch(*(np.zeros(size) for size in (3, 3, 6, 6, model.nq, model.nv, model.nv, model.nv, model.nv)))
    added = np.ascontiguousarray(added)
    share = inverse(mass_matrix(model) + added) if added.size else added
    return Plant(model._address, data._address, model.opt.timestep, views, scratch, added, share, is_free(model))


def is_free(model: mujoco.MjModel) -> bool:
    """Whether neither constraints nor states of actuators can act on a model that is stepped by Runge-Kutta.

    The engine's parts for contacts, limits, dry friction, equality constraints, tendons, flexes, plugins, activations,
    delays and sleep then change nothing. Of joints with a quaternion, a free joint in first place alone is allowed.
    """
    parts = (model.neq, model.ntendon, model.nflex, model.nplugin, model.na, model.nhistory)
    held = bool(model.jnt_limited.any() or model.dof_frictionloss.any())
    sleeps = bool(model.opt.enableflags & mujoco.mjtEnableBit.mjENBL_SLEEP)
    runge_kutta = model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4
    return runge_kutta and _turns_simply(model) and not (any(parts) or held or sleeps or _touches(model))


def _turns_simply(model: mujoco.MjModel) -> bool:
    free, ball = mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_BALL
    return not (np.isin(model.jnt_type[1:], (free, ball)).any() or ball in model.jnt_type[:1])


def _touches(model: mujoco.MjModel) -> bool:
    """Whether two geoms may come into contact: contacts are on, and a pair is listed or the bits of two match."""
    if model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT:
        return False
    own, others = np.bitwise_or.reduce(model.geom_contype), np.bitwise_or.reduce(model.geom_conaffinity)
    return bool(model.npair or own & others)


def mass_matrix(model: mujoco.MjModel) -> Array:
    """Mass matrix M (nv, nv) of the bodies in the first pose; for a free joint about the body's origin, body frame."""
    probe = mujoco.MjData(model)
    mujoco.mj_forward(model, probe)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, probe, mass)
    return mass
