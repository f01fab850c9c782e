"""Properties of a free body in a fluid, from the engine: added mass, drag, righting moment, actuator wrenches."""

from __future__ import annotations

from copy import copy

import mujoco
import numpy as np

from scenarios.arrays import Array
from sim.portable_arithmetic import product

COEFFICIENT, FIRST_MASS, FIRST_INERTIA = 0, 6, 9
"""Columns of geom_fluid: whether the ellipsoid model acts, virtual mass (3) and inertia (3) at unit density."""


def added_mass(model: mujoco.MjModel) -> Array:
    """M_A = sum over ellipsoids of T^T rho diag(m_A, I_A) T; T (6, 6) takes the body's velocity to the geom's.

    Virtual masses and inertias are the engine's ([Tuckerman1925]), consistent with the engine's Coriolis terms.
    Transformation of a mass matrix to a new origin: [Fossen2011] section 7.5.
    """
    data = _at_identity(model)
    total = np.zeros((6, 6))
    for geom in np.flatnonzero(model.geom_fluid[:, COEFFICIENT]):
        fluid = model.geom_fluid[geom]
        turn, offset = data.geom_xmat[geom].reshape(3, 3), data.geom_xpos[geom]
        to_geom = np.zeros((6, 6))
        to_geom[:3, :3] = to_geom[3:, 3:] = turn.T
        to_geom[:3, 3:] = -product(turn.T, _skew(offset))
        virtual = np.diag(fluid[FIRST_MASS : FIRST_INERTIA + 3]) * model.opt.density
        total += fluid[COEFFICIENT] * product(to_geom.T, product(virtual, to_geom))
    return total


def righting_arm(model: mujoco.MjModel) -> Array:
    """a = sum of g m (c - 1) r (3,), N m, with c the buoyancy per weight of the part at r; the moment is a x R^T z."""
    data = _at_identity(model)
    lift_N = -model.opt.gravity[2] * model.body_mass * (model.body_gravcomp - 1.0)
    return np.asarray(product(lift_N[None], data.xipos)[0])


def drag(model: mujoco.MjModel) -> Array:
    """Drag D (6, 6), column j the force against unit velocity j, evaluated by the engine (added mass left out)."""
    viscous = copy(model)
    viscous.geom_fluid[:, FIRST_MASS:] = 0.0
    data = _at_identity(viscous)
    rest = data.qfrc_passive.copy()
    columns = []
    for velocity in np.eye(6):
        data.qvel[:] = velocity
        mujoco.mj_forward(viscous, data)
        columns.append(rest - data.qfrc_passive)
    return np.array(columns).T


def wrenches(model: mujoco.MjModel) -> Array:
    """Wrench (6, nu) in the body frame of a unit command to each actuator of the level body."""
    data = _at_identity(model)
    columns = []
    for command in np.eye(model.nu):
        data.ctrl[:] = command
        mujoco.mj_forward(model, data)
        columns.append(data.qfrc_actuator.copy())
    return np.array(columns).T


def _at_identity(model: mujoco.MjModel) -> mujoco.MjData:
    """The vehicle at the origin, level, at rest, in a still fluid."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return data


def _skew(v: Array) -> Array:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
