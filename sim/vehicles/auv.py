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
from sim.engine import StateLog
from sim.vehicles.base import Kinematics, Vehicle, VehicleTable, free_body_kinematics
from sim.vehicles.fluid import added_mass
from sim.vehicles.free_body_control import MEMORY_SIZE, follow, tracking_gains

THRUSTERS = 8
"""The first actuators of the MJCF, before the two ballast forces."""

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
        """Gains of `follow`; ballast W at trim_m ahead acts as W (1 - trim_m) at the centre and W trim_m 1 m ahead."""
        force_N, ahead = (-phase.ballast_N, phase.trim_m) if isinstance(phase, Descent | Ascent) else (0.0, 0.0)
        ballast_N = {"ballast_centre": force_N * (1.0 - ahead), "ballast_ahead": force_N * ahead}
        return tracking_gains(model, phase.powered, ballast_N)

    def added_mass(self, model: mujoco.MjModel) -> Array:
        """Added mass of hull and planes, 6 x 6."""
        return added_mass(model)

    def flow(self, n: int, rng: np.random.Generator, memory: dict[str, Any]) -> Array:
        """The uniform current (n, 3), m/s, ENU."""
        return np.tile(np.asarray(self.spec.current_enu_m_s, dtype=np.float64), (n, 1))

    def currents_A(self, ctrl: Array) -> Array:
        """I = k |T|^1.5 (n, 8): power of a propeller at thrust T (momentum theory), at constant voltage."""
        thrust_N = np.abs(ctrl[:, :THRUSTERS])
        return np.asarray(AMPERE_PER_N_1_5 * thrust_N * np.sqrt(thrust_N))

    def kinematics(self, model: mujoco.MjModel, log: StateLog) -> Kinematics:
        """Motion of the hull's centre."""
        return free_body_kinematics(log)
