"""A phase of the motion: its TOML table, and the reference that guidance follows in it."""

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
"""Within which a speed or an angle may change at the soonest: five of the engine's steps."""


@dataclass(frozen=True)
class Start:
    """Where the vehicle's true state is when a phase begins: ENU position and heading from east."""

    pos_enu_m: tuple[float, float, float]
    yaw_rad: float
    speed_m_s: float = 0.0


class Ability(StrEnum):
    """What a vehicle may be able to do, and a phase may need; the value ends "the vehicle cannot ..."."""

    TRAVEL = "follow a path through space"
    TILT = "roll or pitch without moving away"
    SWAY = "tilt by swaying on the spot"
    DIVE = "sink and rise by its weight alone"
    POINT = "turn to every attitude in its place"


class PhaseBase(BaseModel, ABC):
    """One phase. A subclass has a `kind`, its parameters, and the reference as a pure function of time.

    `needs`: what a vehicle must be able to do. `tracked`: whether guidance steers its position all along, so that
    the distance from the reference says how well the vehicle follows.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
    kind: str
    needs: ClassVar[Ability] = Ability.TRAVEL
    powered: ClassVar[bool] = True
    tracked: ClassVar[bool] = True

    @property
    def label(self) -> str:
        """Value of the dataset's `phase` column."""
        return self.kind

    @property
    def tilted(self) -> bool:
        """Whether roll or pitch is commanded on top of the path, which needs Ability.TILT."""
        return False

    @property
    @abstractmethod
    def duration_s(self) -> float:
        """Length of the phase; the longest allowed for a phase that ends at a depth."""

    @property
    def end_depth_m(self) -> float | None:
        """Depth that ends the phase, for unpowered phases; None: it ends by time alone."""
        return None

    @property
    def settle_s(self) -> float:
        """Time after which tracking is judged: the run-in onto the path."""
        return 0.0

    @abstractmethod
    def reference(self, start: Start, t_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Reference at times t_s (n,) since the phase began: (n, 18), see REFERENCE_COLUMNS."""
