"""A vehicle: its table in a scenario, its MuJoCo model, its controller, its looks, and what its motors draw."""

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
"""Physics and control step; Runge-Kutta of fourth order (errors far below a millimetre at this step)."""


@dataclass(frozen=True)
class Kinematics:
    """Motion of the body frame: pos, velocity and acceleration (n, 3) in ENU, q (n, 4), rate (n, 3) in the body."""

    pos_enu_m: Array
    q: Array
    velocity_m_s: Array
    rate_rad_s: Array
    accel_m_s2: Array


class VehicleTable(Table):
    """The `vehicle` table of a scenario; a subclass says its `kind`, one word, and what else a user may set."""

    kind: str


@dataclass(frozen=True)
class Vehicle(ABC):
    """One vehicle, made from its table of the scenario (`spec`). A subclass says all about it:

    ===========  =================================================================================================
    name         the `kind` in its table
    table        its table in a scenario, with what a user may set
    summary      a line for lists
    noun         the vehicle in a sentence, with its article
    abilities    what it can do; a phase that needs another ability is refused
    model_file   its MJCF in sim/models; the geoms that are not transparent are its picture
    body         the body that carries the magnetometer
    motors       how many currents `currents_A` gives
    control      numba function of signature `sim.engine.control_signature`, run each STEP_S; its reference row has
                 the columns of scenarios.paths.base.REFERENCE_COLUMNS
    memory_size  how many numbers the control keeps from step to step
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
    """Roll and pitch that a planned motion asks of it at most, where the user says nothing else."""
    turning_deg_s: ClassVar[float] = 20.0
    """Rate at which a planned motion turns it from one attitude to the next."""
    drag_1_m: ClassVar[float] = 0.0
    """Drag over mass and square of speed, against which a planned motion pushes it to and fro."""
    own_channels: ClassVar[Mapping[str, tuple[str, str]]] = {}
    """Unit and meaning of what it gives beside its motors' currents, by the name of the column."""

    def __init_subclass__(cls) -> None:
        unsaid = [name for name in REQUIRED if not hasattr(cls, name)]
        if unsaid:
            raise TypeError(f"vehicle {cls.__name__} does not say its {', '.join(unsaid)}")

    @classmethod
    def can(cls, phase: PhaseBase | type[PhaseBase]) -> bool:
        """Whether it is able to do a phase, level."""
        return phase.needs in cls.abilities

    def model(self) -> mujoco.MjModel:
        """The compiled MJCF; its step is STEP_S, its integrator RK4."""
        return mujoco.MjModel.from_xml_path(str(MODELS / self.model_file))

    @abstractmethod
    def place(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Set the initial state, at rest (or in trimmed flight)."""

    @abstractmethod
    def gains(self, model: mujoco.MjModel, phase: PhaseBase) -> Array:
        """Constants that the controller uses in this phase (allocation, mass, gains, ballast), flat."""

    def added_mass(self, model: mujoco.MjModel) -> Array:
        """Added mass M_A (6, 6) in the body frame about the body's origin; (0, 0): none."""
        return np.zeros((0, 0))

    def flow(self, n: int, rng: np.random.Generator, memory: dict[str, Any]) -> Array:
        """Wind or current (n, 3) at the next n steps, m/s, ENU."""
        return np.zeros((n, 3))

    @property
    def random_flow(self) -> bool:
        """Whether its flow draws random numbers: otherwise all runs of one path are one motion."""
        return False

    @abstractmethod
    def currents_A(self, ctrl: Array) -> Array:
        """Motor currents (n, motors) from the actuator commands (n, nu)."""

    def channels(self, log: StateLog) -> dict[str, Array]:
        """Its `own_channels`, each (n,), from the engine's log, such as a battery's charge; none by default."""
        return {}

    @abstractmethod
    def kinematics(self, model: mujoco.MjModel, log: StateLog) -> Kinematics:
        """Motion from the engine's log."""

    def turns(self, q: Array) -> dict[str, Array]:
        """Attitude (n, 4) of each body that turns on its own, from that of the main body, which is the first."""
        return {self.body: q}

    def geoms(self) -> tuple[Geom, ...]:
        """Its picture: each solid in the frame of its body, one of `turns` or the world."""
        return visible_geoms(self.model(), self.turns(np.zeros((0, 4))))


REQUIRED = ("name", "table", "summary", "noun", "abilities", "model_file", "body", "motors", "control")
"""What a vehicle must say; a class without is refused when it is made."""


def free_body_kinematics(log: StateLog) -> Kinematics:
    """Motion of a free joint: MuJoCo's qvel is linear in the world frame and angular in the body frame."""
    return Kinematics(log.qpos[:, :3], log.qpos[:, 3:], log.qvel[:, :3], log.qvel[:, 3:], log.accel[:, :3])
