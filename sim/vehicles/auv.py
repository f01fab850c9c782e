"""The torpedo-shaped AUV: eight thrusters, ballast for the dive, added mass, uniform ocean current."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from typing import Annotated, Any, ClassVar, Literal

import mujoco
import numpy as np
from pydantic import Field

from scenarios.paths.base import PhaseBase
from scenarios.paths.dive import Ascent, Descent
from sim.engine import Log, mass_matrix
from sim.portable import product, pseudo_inverse
from sim.state import Array
from sim.vehicles.auv_control import GAINS_SIZE, MEMORY_SIZE, THRUSTERS, follow
from sim.vehicles.base import Kinematics, Vehicle, VehicleTable, free_body_kinematics

FEEDBACK = np.array([2.25, 3.0, 0.8, 6.25, 5.0, 4.0, 1.0])
"""Position 1/s^2, velocity 1/s, integral 1/s^3; attitude, rate, integral likewise; limit of linear feedback, m/s^2."""

AMPERE_PER_N_1_5 = 0.068
"""Current of a thruster: 24 A at 50 N on 16 V, as small commercial ones draw in static tests."""

FIRST_COEFFICIENT, FIRST_MASS, FIRST_INERTIA = 0, 6, 9
"""Columns of geom_fluid: whether the ellipsoid model acts, virtual mass (3) and inertia (3) at unit density."""


WaterSpeed = Annotated[float, Field(ge=-10, le=10)]


class AuvSpec(VehicleTable):
    """The torpedo-shaped AUV, in a uniform ocean current."""

    kind: Literal["auv"]
    current_enu_m_s: tuple[WaterSpeed, WaterSpeed, WaterSpeed] = (0.0, 0.0, 0.0)
    depth_m: float = Field(0.0, ge=0, le=11_000, description="depth at the start")
    heading_deg: float = Field(0.0, ge=-360, le=360, description="counter-clockwise from east")


class Auv(Vehicle):
    """Neutral torpedo of 83 kg, 2 m long, with eight thrusters, and a ballast for the dive."""

    spec: AuvSpec
    name: ClassVar[str] = "auv"
    table: ClassVar[type[VehicleTable]] = AuvSpec
    summary: ClassVar[str] = "neutral torpedo with eight thrusters: drag, added mass, righting moment, ocean current"
    model_file: ClassVar[str] = "auv.xml"
    body: ClassVar[str] = "auv"
    motors: ClassVar[int] = THRUSTERS
    memory_size: ClassVar[int] = MEMORY_SIZE
    control: ClassVar[Callable[..., None]] = staticmethod(follow)

    def place(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """At rest over ground and level, at the scenario's depth and heading."""
        half = 0.5 * np.radians(self.spec.heading_deg)
        data.qpos[:] = [0.0, 0.0, -self.spec.depth_m, np.cos(half), 0.0, 0.0, np.sin(half)]
        data.qvel[:] = 0.0

    def gains(self, model: mujoco.MjModel, phase: PhaseBase) -> Array:
        """Flat constants of `auv_control.follow`; ballast W at trim_m acts as W (1 - trim), and W trim 1 m ahead."""
        ballast = np.zeros(2)
        if isinstance(phase, Descent | Ascent):
            ballast = -phase.ballast_N * np.array([1.0 - phase.trim_m, phase.trim_m])
        mass = mass_matrix(model) + self.added_mass(model)
        allocation = pseudo_inverse(_thruster_wrenches(model))
        limit_N = model.actuator_ctrlrange[:THRUSTERS, 1].min()
        powered = float(phase.powered)
        parts = (powered, ballast, FEEDBACK, _righting_arm(model), mass, _drag(model), allocation, limit_N)
        gains = np.concatenate([np.ravel(part) for part in parts])
        assert gains.size == GAINS_SIZE
        return gains

    def added_mass(self, model: mujoco.MjModel) -> Array:
        """M_A = sum over ellipsoids of T^T rho diag(m_A, I_A) T; T (6, 6) takes the body's velocity to the geom's.

        The virtual masses and inertias are the engine's own ([Tuckerman1925]), so that they match its Coriolis terms.
        Transformation of a mass matrix to another origin: [Fossen2011] section 7.5.
        """
        data = _at_identity(model)
        total = np.zeros((6, 6))
        for geom in np.flatnonzero(model.geom_fluid[:, FIRST_COEFFICIENT]):
            fluid = model.geom_fluid[geom]
            turn, offset = data.geom_xmat[geom].reshape(3, 3), data.geom_xpos[geom]
            to_geom = np.zeros((6, 6))
            to_geom[:3, :3] = to_geom[3:, 3:] = turn.T
            to_geom[:3, 3:] = -product(turn.T, _skew(offset))
            virtual = np.diag(fluid[FIRST_MASS : FIRST_INERTIA + 3]) * model.opt.density
            total += fluid[FIRST_COEFFICIENT] * product(to_geom.T, product(virtual, to_geom))
        return total

    def flow(self, n: int, rng: np.random.Generator, memory: dict[str, Any]) -> Array:
        """The uniform current (n, 3), m/s, ENU."""
        return np.tile(np.asarray(self.spec.current_enu_m_s, dtype=np.float64), (n, 1))

    def currents_A(self, ctrl: Array) -> Array:
        """I = k |T|^1.5 (n, 8): a propeller's power grows with thrust so (momentum theory), at constant voltage."""
        thrust_N = np.abs(ctrl[:, :THRUSTERS])
        return np.asarray(AMPERE_PER_N_1_5 * thrust_N * np.sqrt(thrust_N))

    def kinematics(self, model: mujoco.MjModel, log: Log) -> Kinematics:
        """Motion of the hull's centre."""
        return free_body_kinematics(log)


def _skew(v: Array) -> Array:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def _at_identity(model: mujoco.MjModel) -> mujoco.MjData:
    """The vehicle at the origin, level, at rest, in still water."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return data


def _righting_arm(model: mujoco.MjModel) -> Array:
    """a = sum of g m (c - 1) r (3,), N m, with c the buoyancy per weight of the part at r; the moment is a x R^T z."""
    data = _at_identity(model)
    lift_N = -model.opt.gravity[2] * model.body_mass * (model.body_gravcomp - 1.0)
    return np.asarray(product(lift_N[None], data.xipos)[0])


def _drag(model: mujoco.MjModel) -> Array:
    """Drag D (6, 6), column j the force against unit velocity j, by asking the engine (without its added mass)."""
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


def _thruster_wrenches(model: mujoco.MjModel) -> Array:
    """Wrench (6, 8) in the body frame of each thruster's unit thrust."""
    data = _at_identity(model)
    columns = []
    for thrust in np.eye(model.nu)[:THRUSTERS]:
        data.ctrl[:] = thrust
        mujoco.mj_forward(model, data)
        columns.append(data.qfrc_actuator.copy())
    return np.array(columns).T
