"""A vehicle: its MuJoCo model, its controller, and what its motors draw."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import mujoco
import numpy as np

from scenarios.paths.base import PhaseBase
from scenarios.spec import Table
from sim.engine import Log
from sim.state import Array

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
    """One vehicle, made from its table of the scenario (`spec`).

    `control` is a numba function of signature `sim.engine.control_signature`; its reference row has the columns of
    scenarios.paths.base.REFERENCE_COLUMNS.
    """

    spec: Any
    name: ClassVar[str]
    table: ClassVar[type[VehicleTable]]
    summary: ClassVar[str]
    model_file: ClassVar[str]
    body: ClassVar[str]
    motors: ClassVar[int]
    memory_size: ClassVar[int] = 1
    tilts: ClassVar[bool] = True
    """Whether it can roll and pitch without moving away."""
    control: ClassVar[Callable[..., None]]

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

    @abstractmethod
    def currents_A(self, ctrl: Array) -> Array:
        """Motor currents (n, motors) from the actuator commands (n, nu)."""

    @abstractmethod
    def kinematics(self, model: mujoco.MjModel, log: Log) -> Kinematics:
        """Motion from the engine's log."""


def free_body_kinematics(log: Log) -> Kinematics:
    """Motion of a free joint: MuJoCo's qvel is linear in the world frame and angular in the body frame."""
    return Kinematics(log.qpos[:, :3], log.qpos[:, 3:], log.qvel[:, :3], log.qvel[:, 3:], log.accel[:, :3])
