"""The base of all phases of the motion: a TOML table, and the reference that guidance follows."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import StrEnum
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

REFERENCE_COLUMNS = (
    *("x_m", "y_m", "z_m", "vx_m_s", "vy_m_s", "vz_m_s", "ax_m_s2", "ay_m_s2", "az_m_s2"),
    *("yaw_rad", "pitch_rad", "roll_rad", "yaw_rad_s", "pitch_rad_s", "roll_rad_s"),
    *("yaw_rad_s2", "pitch_rad_s2", "roll_rad_s2"),
)
"""Columns of a reference: position and its derivatives (ENU), then R_wb = Rz(yaw) Ry(pitch) Rx(roll) (FLU body;
a positive pitch lowers the nose) and the derivatives of the three angles."""

LEAST_RAMP_S = 0.1
"""The shortest time for a change of speed or angle: five of the engine's steps."""


@dataclass(frozen=True)
class Start:
    """The vehicle's true state at the start of a phase: ENU position, heading from east, speed."""

    pos_enu_m: tuple[float, float, float]
    yaw_rad: float
    speed_m_s: float = 0.0


class Ability(StrEnum):
    """An ability of a vehicle, which a phase may need; the value completes "the vehicle cannot ..."."""

    TRAVEL = "follow a path through space"
    TILT = "roll or pitch without moving away"
    SWAY = "tilt by swaying on the spot"
    DIVE = "sink and rise by its weight alone"
    POINT = "turn to every attitude in its place"


class PhaseBase(BaseModel, ABC):
    """A phase. A subclass has a `kind`, parameters, and the reference as a pure function of time.

    `needs`: the ability that a vehicle must have. `powered`: whether thrusters run. `tracked`: whether guidance steers
    the position all along, so that the distance from the reference measures the tracking.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
    kind: str
    needs: ClassVar[Ability] = Ability.TRAVEL
    powered: ClassVar[bool] = True
    tracked: ClassVar[bool] = True

    @property
    def label(self) -> str:
        """The value in the dataset's `phase` column."""
        return self.kind

    @property
    def tilted(self) -> bool:
        """Whether roll or pitch is commanded in addition to the path, which needs Ability.TILT."""
        return False

    @property
    @abstractmethod
    def duration_s(self) -> float:
        """The length of the phase; for a phase that ends at a depth, the longest allowed."""

    @property
    def end_depth_m(self) -> float | None:
        """The depth that ends an unpowered phase; None for a phase that ends by time alone."""
        return None

    @property
    def settle_s(self) -> float:
        """The run-in onto the path, after which tracking is judged."""
        return 0.0

    @abstractmethod
    def reference(self, start: Start, t_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the reference at times t_s (n,) since the start of the phase: (n, 18), see REFERENCE_COLUMNS."""
