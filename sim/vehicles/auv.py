"""The torpedo-shaped AUV: eight thrusters, ballast for the dive, added mass, uniform ocean current."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, ClassVar, Literal

import mujoco
import numpy as np
from pydantic import Field

from scenarios.arrays import Array
from scenarios.paths.base import Ability, PhaseBase
from scenarios.paths.dive import Ascent, Descent
from sim.engine import StateLog, mass_matrix
from sim.portable_arithmetic import pseudo_inverse
from sim.vehicles.auv_control import GAINS_SIZE, MEMORY_SIZE, THRUSTERS, follow
from sim.vehicles.base import Kinematics, Vehicle, VehicleTable, free_body_kinematics
from sim.vehicles.fluid import added_mass, drag, righting_arm, wrenches

FEEDBACK = np.array([2.25, 3.0, 0.8, 6.25, 5.0, 4.0, 1.0])
"""Position 1/s^2, velocity 1/s, integral 1/s^3; attitude, rate, integral likewise; limit of linear feedback, m/s^2."""

AMPERE_PER_N_1_5 = 0.068
"""Current of a thruster: 24 A at 50 N on 16 V, as small commercial ones draw in static tests."""


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
    noun: ClassVar[str] = "an AUV"
    abilities: ClassVar[frozenset[Ability]] = frozenset({Ability.TRAVEL, Ability.TILT, Ability.DIVE})
    model_file: ClassVar[str] = "auv.xml"
    body: ClassVar[str] = "auv"
    motors: ClassVar[int] = THRUSTERS
    memory_size: ClassVar[int] = MEMORY_SIZE
    tilts_deg: ClassVar[tuple[float, float]] = (20.0, 25.0)
    turning_deg_s: ClassVar[float] = 5.0
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
        mass = mass_matrix(model) + added_mass(model)
        allocation = pseudo_inverse(wrenches(model, THRUSTERS))
        limit_N = model.actuator_ctrlrange[:THRUSTERS, 1].min()
        powered = float(phase.powered)
        parts = (powered, ballast, FEEDBACK, righting_arm(model), mass, drag(model), allocation, limit_N)
        gains = np.concatenate([np.ravel(part) for part in parts])
        assert gains.size == GAINS_SIZE
        return gains

    def added_mass(self, model: mujoco.MjModel) -> Array:
        """That of hull and planes, 6 x 6."""
        return added_mass(model)

    def flow(self, n: int, rng: np.random.Generator, memory: dict[str, Any]) -> Array:
        """The uniform current (n, 3), m/s, ENU."""
        return np.tile(np.asarray(self.spec.current_enu_m_s, dtype=np.float64), (n, 1))

    def currents_A(self, ctrl: Array) -> Array:
        """I = k |T|^1.5 (n, 8): a propeller's power grows with thrust so (momentum theory), at constant voltage."""
        thrust_N = np.abs(ctrl[:, :THRUSTERS])
        return np.asarray(AMPERE_PER_N_1_5 * thrust_N * np.sqrt(thrust_N))

    def kinematics(self, model: mujoco.MjModel, log: StateLog) -> Kinematics:
        """Motion of the hull's centre."""
        return free_body_kinematics(log)
