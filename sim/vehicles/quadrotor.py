"""The quadrotor: four rotors, aerodynamic drag, wind with gusts."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

import mujoco
import numpy as np
from pydantic import Field

from scenarios.arrays import Array
from scenarios.paths.base import Ability, PhaseBase
from sim.engine import StateLog
from sim.processes import GaussMarkov
from sim.vehicles.base import STEP_S, Kinematics, Vehicle, VehicleTable, free_body_kinematics
from sim.vehicles.quadrotor_control import SIZE, control

GUST_CORRELATION_S = 5.0
"""L / V of the vertical Dryden spectrum [MIL-F-8785C] at a height of 30 m and an airspeed of 6 m/s."""
AMPERE_PER_N32 = 0.4
"""Momentum theory: P = T^1.5 / sqrt(2 rho A) over 0.5 (rotor and motor) at 14.8 V, rotor radius 0.12 m."""


WindSpeed = Annotated[float, Field(ge=-100, le=100)]


class QuadrotorSpec(VehicleTable):
    """The quadrotor, in a uniform wind with gusts."""

    kind: Literal["quadrotor"]
    wind_enu_m_s: tuple[WindSpeed, WindSpeed, WindSpeed] = (0.0, 0.0, 0.0)
    gust_std_m_s: float = Field(0.0, ge=0, le=20)
    height_m: float = Field(30.0, ge=0, le=5_000, description="height at the start")
    heading_deg: float = Field(0.0, ge=-360, le=360, description="counter-clockwise from east")


class Quadrotor(Vehicle):
    """1.5 kg, four rotors in X; a geometric controller follows position and yaw.

    A quadrotor cannot hold a tilt without accelerating: commanded roll and pitch of the reference are ignored.
    """

    name: ClassVar[str] = "quadrotor"
    table: ClassVar[type[VehicleTable]] = QuadrotorSpec
    summary: ClassVar[str] = "1.5 kg quadrotor with four rotors, aerodynamic drag, wind and gusts"
    noun: ClassVar[str] = "a quadrotor"
    abilities: ClassVar[frozenset[Ability]] = frozenset({Ability.TRAVEL, Ability.SWAY})
    model_file: ClassVar[str] = "quadrotor.xml"
    body: ClassVar[str] = "quadrotor"
    motors: ClassVar[int] = 4
    memory_size: ClassVar[int] = SIZE
    turning_deg_s: ClassVar[float] = 90.0
    drag_1_m: ClassVar[float] = 0.0199
    control = staticmethod(control)

    def place(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Hovering at the height and heading of the spec."""
        mujoco.mj_resetData(model, data)
        half = 0.5 * np.radians(self.spec.heading_deg)
        data.qpos[:] = (0.0, 0.0, self.spec.height_m, np.cos(half), 0.0, 0.0, np.sin(half))
        data.ctrl[:] = 0.25 * model.body_mass.sum() * -model.opt.gravity[2]

    def gains(self, model: mujoco.MjModel, phase: PhaseBase) -> Array:
        """Constants of the plant, in the order of quadrotor_control.CONSTANTS."""
        body, rotor = model.body(self.body), model.actuator("front_left")
        arm_m = model.site("front_left").pos[0]
        return np.array(
            [
                *(body.mass[0], -model.opt.gravity[2], *body.inertia),
                *(arm_m, rotor.gear[5], rotor.ctrlrange[1], drag_N_s2_m2(model)),
            ]
        )

    def flow(self, n: int, rng: np.random.Generator, memory: dict[str, Any]) -> Array:
        """Constant wind and isotropic first-order Gauss-Markov gusts (Dryden's form along the wind), (n, 3) m/s ENU."""
        wind: Array = np.tile(np.array(self.spec.wind_enu_m_s, dtype=np.float64), (n, 1))
        std = self.spec.gust_std_m_s
        if std == 0:
            return wind
        if "gust" not in memory:
            memory["gust"] = GaussMarkov(std, GUST_CORRELATION_S, STEP_S, 3, rng)
        wind += memory["gust"].draw(n)
        return wind

    @property
    def random_flow(self) -> bool:
        """Gusts."""
        return bool(self.spec.gust_std_m_s > 0)

    def currents_A(self, ctrl: Array) -> Array:
        """I = k T^1.5 a motor (momentum theory) at thrust T; a stopped rotor may be a rounding below zero."""
        thrust_N = np.maximum(ctrl, 0.0)
        return np.asarray(AMPERE_PER_N32 * thrust_N * np.sqrt(thrust_N))

    def kinematics(self, model: mujoco.MjModel, log: StateLog) -> Kinematics:
        return free_body_kinematics(log)


def drag_N_s2_m2(model: mujoco.MjModel) -> float:
    """D of the drag -D |v| v: density x coefficient x pi r^2 of the sphere in place of the airframe."""
    hull = model.geom("hull").id
    return float(model.opt.density * model.geom_fluid[hull, 1] * np.pi * model.geom_size[hull, 0] ** 2)
