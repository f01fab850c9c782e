"""A vehicle: table in a scenario, MuJoCo model, controller, picture, motor currents."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import mujoco
import numpy as np

from scenarios.arrays import Array
from scenarios.paths.base import Ability, PhaseBase
from scenarios.table import Table
from sim.engine import StateLog
from sim.vehicles.geoms import Geom, visible_geoms

MODELS = Path(__file__).parent.parent / "models"
STEP_S = 0.02
"""Physics and control step; Runge-Kutta of fourth order (errors far below a millimetre)."""


@dataclass(frozen=True)
class Kinematics:
    """Motion of the body frame: pos, velocity and acceleration (n, 3) in ENU, q (n, 4), rate (n, 3) in the body."""

    pos_enu_m: Array
    q: Array
    velocity_m_s: Array
    rate_rad_s: Array
    accel_m_s2: Array


class VehicleTable(Table):
    """The `vehicle` table of a scenario; a subclass fixes the `kind`, a single word, and adds further settings."""

    kind: str


@dataclass(frozen=True)
class Vehicle(ABC):
    """A vehicle, made from the scenario's table (`spec`). A subclass defines:

    ===========  =================================================================================================
    name         the `kind` in the table
    table        class of the table, with the settings of the vehicle
    summary      a line for lists
    noun         the vehicle in a sentence, with article
    abilities    a phase that needs a missing ability is refused
    model_file   MJCF in sim/models; the visible geoms are the picture
    body         the body with the magnetometer
    motors       number of currents of `currents_A`
    control      numba function of signature `sim.engine.control_signature`, run each STEP_S; the reference row has
                 the columns of scenarios.paths.base.REFERENCE_COLUMNS
    memory_size  length of the memory that the control keeps from step to step
    ===========  =================================================================================================
    """

    spec: Any
    name: ClassVar[str]
    table: ClassVar[type[VehicleTable]]
    summary: ClassVar[str]
    noun: ClassVar[str]
    abilities: ClassVar[frozenset[Ability]]
    model_file: ClassVar[str]
    body: ClassVar[str]
    motors: ClassVar[int]
    control: ClassVar[Callable[..., None]]
    memory_size: ClassVar[int] = 1
    tilts_deg: ClassVar[tuple[float, float]] = (20.0, 20.0)
    """Default limits of roll and pitch in a planned motion."""
    turning_deg_s: ClassVar[float] = 20.0
    """Rate of turn between attitudes in a planned motion."""
    drag_1_m: ClassVar[float] = 0.0
    """Drag over mass and square of speed, for planned motions to and fro."""
    own_channels: ClassVar[Mapping[str, tuple[str, str]]] = {}
    """Unit and meaning of the vehicle's channels in addition to motor currents, by column."""

    def __init_subclass__(cls) -> None:
        unsaid = [name for name in REQUIRED if not hasattr(cls, name)]
        if unsaid:
            raise TypeError(f"vehicle {cls.__name__} does not define its {', '.join(unsaid)}")

    @classmethod
    def can(cls, phase: PhaseBase | type[PhaseBase]) -> bool:
        """Whether the vehicle is able to do a phase, level."""
        return phase.needs in cls.abilities

    def model(self) -> mujoco.MjModel:
        """The compiled MJCF, with step STEP_S and integrator RK4."""
        return mujoco.MjModel.from_xml_path(str(MODELS / self.model_file))

    @abstractmethod
    def place(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Set the initial state, at rest (or in trimmed flight)."""

    @abstractmethod
    def gains(self, model: mujoco.MjModel, phase: PhaseBase) -> Array:
        """Constants of the controller in a phase (allocation, mass, gains, ballast), flat."""

    def added_mass(self, model: mujoco.MjModel) -> Array:
        """Added mass M_A (6, 6) in the body frame about the body's origin; (0, 0): none."""
        return np.zeros((0, 0))

    def flow(self, n: int, rng: np.random.Generator, memory: dict[str, Any]) -> Array:
        """Wind or current (n, 3) at the next n steps, m/s, ENU."""
        return np.zeros((n, 3))

    @property
    def random_flow(self) -> bool:
        """Whether the flow draws random numbers; otherwise all runs of a path share one motion."""
        return False

    @abstractmethod
    def currents_A(self, ctrl: Array) -> Array:
        """Motor currents (n, motors) from the actuator commands (n, nu)."""

    def channels(self, log: StateLog) -> dict[str, Array]:
        """Values (n,) of each of `own_channels` from the engine's log, such as a battery's charge; none by default."""
        return {}

    @abstractmethod
    def kinematics(self, model: mujoco.MjModel, log: StateLog) -> Kinematics:
        """Motion from the engine's log."""

    def turns(self, q: Array) -> dict[str, Array]:
        """Attitude (n, 4) of each separately turning body, from the attitude of the main body, the first."""
        return {self.body: q}

    def geoms(self) -> tuple[Geom, ...]:
        """Picture of the vehicle: each solid in the frame of a body of `turns`, or of the world."""
        return visible_geoms(self.model(), self.turns(np.zeros((0, 4))))


REQUIRED = ("name", "table", "summary", "noun", "abilities", "model_file", "body", "motors", "control")
"""Required attributes of a vehicle, checked when a class is made."""


def free_body_kinematics(log: StateLog) -> Kinematics:
    """Motion of a free joint: MuJoCo's qvel is linear in the world frame and angular in the body frame."""
    return Kinematics(log.qpos[:, :3], log.qpos[:, 3:], log.qvel[:, :3], log.qvel[:, 3:], log.accel[:, :3])
