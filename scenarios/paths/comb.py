"""A lawn-mower survey: parallel lines joined by half turns."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field, model_validator

from scenarios.arrays import Array
from scenarios.paths.base import Start
from scenarios.paths.excited import Excited
from scenarios.paths.jet import Jet, assemble, constant, run
from scenarios.paths.turn import heading, unit_turn


class Comb(Excited):
    """Parallel lines of equal length and spacing at constant speed; the first line runs ahead along the heading.

    The arc length s(t) starts at the vehicle's speed and ends at rest. The plane curve over s consists of lines and of
    turns of continuous curvature whose width is exactly the line spacing. Nothing is tabulated over time.
    """

    kind: Literal["comb"]
    line_length_m: float = Field(gt=0, le=100_000)
    line_spacing_m: float = Field(gt=0, le=10_000)
    lines: int = Field(ge=1, le=10_000)
    speed_m_s: float = Field(gt=0, le=50)
    first_turn: Literal["left", "right"] = "left"

    @model_validator(mode="after")
    def _long_enough(self) -> Comb:
        needed_m = 2.0 * self.speed_m_s * self.run_in_s
        if self.length_m < needed_m:
            raise ValueError(f"the survey must be at least 2 speed_m_s run_in_s = {needed_m:g} m: shorten run_in_s")
        return self

    @property
    def turn_length_m(self) -> float:
        return self.line_spacing_m / unit_turn()[1]

    @property
    def length_m(self) -> float:
        return self.lines * self.line_length_m + (self.lines - 1) * self.turn_length_m

    @property
    def duration_s(self) -> float:
        """The time from rest to rest; a vehicle with initial speed arrives earlier and waits at the end."""
        return self.length_m / self.speed_m_s + self.run_in_s

    def reference(self, start: Start, t_s: Array) -> Array:
        ahead, aside, course = self._curve(self._arc(min(start.speed_m_s, 2.0 * self.speed_m_s), t_s))
        side = 1.0 if self.first_turn == "left" else -1.0
        cos, sin = np.cos(start.yaw_rad), np.sin(start.yaw_rad)
        east = ahead * cos - aside * (side * sin) + start.pos_enu_m[0]
        north = ahead * sin + aside * (side * cos) + start.pos_enu_m[1]
        up = constant(start.pos_enu_m[2], t_s)
        return assemble((east, north, up), course * side + start.yaw_rad, *self.pitch_roll(t_s))

    def _arc(self, initial_m_s: float, t_s: Array) -> Jet:
        ramps_m = (initial_m_s / 2 + self.speed_m_s) * self.run_in_s
        brake_s = self.run_in_s + (self.length_m - ramps_m) / self.speed_m_s
        stop_s = brake_s + self.run_in_s  # beyond it rounding must not let the vehicle creep
        return run(np.minimum(t_s, stop_s), initial_m_s, self.speed_m_s, self.run_in_s, brake_s)

    def _curve(self, arc: Jet) -> tuple[Jet, Jet, Jet]:
        """Return ahead, aside and course along the curve, for a first turn to the left; odd lines run back."""
        period = self.line_length_m + self.turn_length_m
        line = np.clip(np.floor(arc.x / period), 0, self.lines - 1)
        along = arc.x - line * period
        in_turn = np.clip((along - self.line_length_m) / self.turn_length_m, 0.0, 1.0)
        theta, dtheta, ddtheta = heading(in_turn)
        curvature, dcurvature = dtheta / self.turn_length_m, ddtheta / self.turn_length_m**2
        cos, sin = np.cos(theta), np.sin(theta)
        turned = self.turn_length_m * unit_turn()[0](in_turn)
        ahead = arc.through(np.minimum(along, self.line_length_m) + turned[:, 0], cos, -curvature * sin)
        aside = arc.through(line * self.line_spacing_m + turned[:, 1], sin, curvature * cos)
        course = arc.through(theta, curvature, dcurvature)
        back = line % 2  # constant on a line: mirroring by it leaves the derivatives exact
        mirror = 1.0 - 2.0 * back
        return ahead * mirror + back * self.line_length_m, aside, course * mirror + back * np.pi
