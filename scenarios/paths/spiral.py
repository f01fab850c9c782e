"""A horizontal circle or a spiral, the sea calibration of [Zhang2018]."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field, model_validator

from scenarios.arrays import Array
from scenarios.paths.base import Start
from scenarios.paths.excited import Excited
from scenarios.paths.jet import Jet, assemble, run_up


class Spiral(Excited):
    """Circles of constant radius, tangent to the heading at the start, with a constant vertical speed.

    p = c + R s (sin psi, -cos psi), psi' = turn rate (smoothly from the speed at the start), s its sign;
    a positive rate turns left (counter-clockwise from above).
    """

    kind: Literal["spiral"]
    radius_m: float = Field(gt=0, le=10_000)
    turn_rate_deg_s: float = Field(ge=-180, le=180, description="positive: to the left")
    vertical_speed_m_s: float = Field(0.0, ge=-5, le=5, description="up positive")
    time_s: float | None = Field(None, gt=0, le=864_000, alias="duration_s")
    turns: float | None = Field(None, gt=0, le=10_000)

    @model_validator(mode="after")
    def _consistent(self) -> Spiral:
        if self.turn_rate_deg_s == 0:
            raise ValueError("turn_rate_deg_s must not be zero; its sign gives the sense")
        if (self.time_s is None) == (self.turns is None):
            raise ValueError("give either duration_s or turns, and only one of them")
        if self.duration_s <= 2 * self.run_in_s:
            raise ValueError(f"the phase must last longer than two run-ins, 2 * {self.run_in_s:g} s")
        return self

    @property
    def duration_s(self) -> float:
        """The given time, or the time of the turns plus half a run-in for the acceleration from rest."""
        if self.time_s is not None:
            return self.time_s
        assert self.turns is not None
        return self.turns * 360.0 / abs(self.turn_rate_deg_s) + self.run_in_s / 2

    def reference(self, start: Start, t_s: Array) -> Array:
        side = np.sign(self.turn_rate_deg_s)
        initial = side * start.speed_m_s / self.radius_m
        yaw = run_up(t_s, initial, np.radians(self.turn_rate_deg_s), self.run_in_s) + start.yaw_rad
        east, north = self._circle(start, yaw, side * self.radius_m)
        up = run_up(t_s, 0.0, self.vertical_speed_m_s, self.run_in_s) + start.pos_enu_m[2]
        return assemble((east, north, up), yaw, *self.pitch_roll(t_s))

    def _circle(self, start: Start, yaw: Jet, radius_m: float) -> tuple[Jet, Jet]:
        centre_east = start.pos_enu_m[0] - radius_m * np.sin(start.yaw_rad)
        centre_north = start.pos_enu_m[1] + radius_m * np.cos(start.yaw_rad)
        return yaw.sin() * radius_m + centre_east, yaw.cos() * -radius_m + centre_north
