"""Keeping station, and the pilot's calibration of a quadrotor on the spot."""

from __future__ import annotations

import math
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from scenarios.arrays import Array
from scenarios.paths.base import LEAST_RAMP_S, Ability, Start
from scenarios.paths.excited import RunIn
from scenarios.paths.jet import Jet, assemble, constant, run, run_up, sine, window

GRAVITY_M_S2 = 9.81


class Hover(RunIn):
    """Comes to rest from the speed at the start, then keeps station and heading."""

    kind: Literal["hover"]
    time_s: float = Field(60.0, gt=0, le=864_000, alias="duration_s")

    @property
    def duration_s(self) -> float:
        return self.time_s

    def reference(self, start: Start, t_s: Array) -> Array:
        level = constant(0.0, t_s)
        return assemble(at_rest(start, t_s, self.run_in_s), constant(start.yaw_rad, t_s), level, level)


def at_rest(start: Start, t_s: Array, run_in_s: float) -> tuple[Jet, Jet, Jet]:
    """Return the position: from the speed at the start to rest, along the heading."""
    way = run_up(t_s, start.speed_m_s, 0.0, run_in_s)
    east = way * np.cos(start.yaw_rad) + start.pos_enu_m[0]
    north = way * np.sin(start.yaw_rad) + start.pos_enu_m[1]
    return east, north, constant(start.pos_enu_m[2], t_s)


class Rotate(RunIn):
    """Yaws on the spot and sways along the body's x and y axes in turn, which forces the vehicle to tilt.

    Sway A sin(w t), A = g tan(tilt) / w^2: an acceleration g tan(tilt) needs the tilt. Each bout of sway is windowed.
    """

    kind: Literal["rotate"]
    needs: ClassVar[Ability] = Ability.SWAY
    time_s: float = Field(120.0, gt=0, le=864_000, alias="duration_s")
    turn_rate_deg_s: float = Field(20.0, ge=-180, le=180, description="positive: to the left")
    tilt_amplitude_deg: float = Field(15.0, ge=0, le=45)
    tilt_period_s: float = Field(4.0, ge=1, le=60)
    run_in_s: float = Field(5.0, ge=LEAST_RAMP_S, le=600)

    @model_validator(mode="after")
    def _room_for_sway(self) -> Rotate:
        needed_s = max(8.0 * self.tilt_period_s, 2.0 * self.run_in_s)
        if self.time_s < needed_s:
            raise ValueError(f"duration_s must be at least {needed_s:g}: eight tilt_period_s and two run_in_s")
        return self

    @property
    def duration_s(self) -> float:
        return self.time_s

    def reference(self, start: Start, t_s: Array) -> Array:
        rate = np.radians(self.turn_rate_deg_s)
        yaw = run(t_s, 0.0, rate, self.run_in_s, self.duration_s - self.run_in_s) + start.yaw_rad
        sway_x, sway_y = self._sway(t_s)
        east = yaw.cos() * sway_x - yaw.sin() * sway_y + start.pos_enu_m[0]
        north = yaw.sin() * sway_x + yaw.cos() * sway_y + start.pos_enu_m[1]
        level = constant(0.0, t_s)
        return assemble((east, north, constant(start.pos_enu_m[2], t_s)), yaw, level, level)

    def _sway(self, t_s: Array) -> tuple[Jet, Jet]:
        """Return the sway along body x and y, in an even number of bouts of about four periods each."""
        bouts = 2 * round(self.duration_s / (8.0 * self.tilt_period_s))
        bout_s = self.duration_s / bouts
        bout = np.clip(np.floor(t_s / bout_s), 0, bouts - 1)
        local = t_s - bout * bout_s
        rate_rad_s = 2.0 * np.pi / self.tilt_period_s
        amplitude_m = GRAVITY_M_S2 * math.tan(math.radians(self.tilt_amplitude_deg)) / rate_rad_s**2
        sway = window(local, bout_s, self.tilt_period_s) * sine(local, amplitude_m, self.tilt_period_s)
        return sway * (1 - bout % 2), sway * (bout % 2)
