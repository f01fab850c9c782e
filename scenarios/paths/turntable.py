"""Turntable phases: stops, full turns, and a tumble over the whole sphere, from level rest to level rest."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from scenarios.arrays import Array
from scenarios.paths.base import LEAST_RAMP_S, Ability, Start
from scenarios.paths.excited import RunIn
from scenarios.paths.jet import Jet, assemble, constant, run, sine, smoothstep, window

AXES = ("yaw", "pitch", "roll")


class TurntablePhase(RunIn):
    """A motion of the three hinges at constant position."""

    needs: ClassVar[Ability] = Ability.POINT
    tracked: ClassVar[bool] = False
    run_in_s: float = Field(2.0, ge=LEAST_RAMP_S, le=60)

    @property
    def label(self) -> str:
        return "turntable"

    def place(self, start: Start, angles: tuple[Jet, Jet, Jet], t_s: Array) -> Array:
        """Return the reference for hinge angles (yaw, pitch, roll), yaw counted from the yaw at the start."""
        east, north, up = (constant(p, t_s) for p in start.pos_enu_m)
        return assemble((east, north, up), angles[0] + start.yaw_rad, *angles[1:])


class TurntableStops(TurntablePhase):
    """Steps of equal size about one hinge with a rest before each ([Zhou2012]: 12 stops of 30 degrees clockwise).

    After the last rest the table returns to the initial angle, by the nearest whole turn.
    """

    kind: Literal["turntable_stops"]
    axis: Literal["yaw", "pitch", "roll"] = "yaw"
    stops: int = Field(12, ge=2, le=3600)
    step_deg: float = Field(-30.0, ge=-180, le=180, description="about the hinge's axis; yaw: negative is clockwise")
    dwell_s: float = Field(20.0, gt=0, le=3600)
    move_s: float = Field(5.0, ge=LEAST_RAMP_S, le=600)

    @property
    def settle_s(self) -> float:
        return 0.0

    @property
    def home_deg(self) -> float:
        """The angle of the last move, to the nearest whole turn."""
        return 360.0 * round(self.stops * self.step_deg / 360.0) - (self.stops - 1) * self.step_deg

    @property
    def home_s(self) -> float:
        return self.move_s * max(1.0, abs(self.home_deg) / max(abs(self.step_deg), 1e-9))

    @model_validator(mode="after")
    def _moves(self) -> TurntableStops:
        if self.step_deg == 0:
            raise ValueError("step_deg must not be zero")
        return self

    @property
    def duration_s(self) -> float:
        return self.stops * self.dwell_s + (self.stops - 1) * self.move_s + self.home_s

    def reference(self, start: Start, t_s: Array) -> Array:
        cycle_s = self.dwell_s + self.move_s
        stop = np.clip(np.floor(t_s / cycle_s), 0, self.stops - 1)
        last = stop == self.stops - 1
        move = smoothstep(t_s - stop * cycle_s - self.dwell_s, np.where(last, self.home_s, self.move_s))
        angle = move * np.radians(np.where(last, self.home_deg, self.step_deg)) + np.radians(self.step_deg) * stop
        still = constant(0.0, t_s)
        yaw, pitch, roll = (angle if axis == self.axis else still for axis in AXES)
        return self.place(start, (yaw, pitch, roll), t_s)


class TurntableTurns(TurntablePhase):
    """A full turn about each body axis in sequence (x, y, z), then about all three together ([Long2013])."""

    kind: Literal["turntable_turns"]
    rate_deg_s: float = Field(10.0, ge=0.1, le=90)

    @property
    def turn_s(self) -> float:
        """The time of a full turn from rest to rest."""
        return 360.0 / self.rate_deg_s + self.run_in_s

    @model_validator(mode="after")
    def _gentle(self) -> TurntableTurns:
        if self.run_in_s > 360.0 / self.rate_deg_s:
            raise ValueError(f"run_in_s must be at most 360 / rate_deg_s = {360.0 / self.rate_deg_s:g}")
        return self

    @property
    def duration_s(self) -> float:
        return 4.0 * self.turn_s

    def reference(self, start: Start, t_s: Array) -> Array:
        roll, pitch, yaw, together = (self._turn(t_s - k * self.turn_s) for k in range(4))
        return self.place(start, (yaw + together, pitch + together, roll + together), t_s)

    def _turn(self, t_s: Array) -> Jet:
        inside = np.clip(t_s, 0.0, self.turn_s)
        return run(inside, 0.0, np.radians(self.rate_deg_s), self.run_in_s, self.turn_s - self.run_in_s)


class Tumble(TurntablePhase):
    """Turns about all three hinges with incommensurate periods, over the whole sphere.

    roll = A_r sin(2 pi t / P_r + p_r), pitch likewise, each windowed over run_in_s at both ends; yaw at constant rate.
    """

    kind: Literal["tumble"]
    time_s: float = Field(360.0, gt=0, le=864_000, alias="duration_s")
    run_in_s: float = Field(10.0, ge=LEAST_RAMP_S, le=600)
    roll_amplitude_deg: float = Field(180.0, ge=0, le=720)
    roll_period_s: float = Field(64.7751, ge=1, le=3600)
    roll_phase_deg: float = Field(0.0, ge=-360, le=360)
    pitch_amplitude_deg: float = Field(88.0, ge=0, le=720)
    pitch_period_s: float = Field(118.5507, ge=1, le=3600)
    pitch_phase_deg: float = Field(0.0, ge=-360, le=360)
    yaw_rate_deg_s: float = Field(6.3025, ge=-90, le=90)

    @property
    def label(self) -> str:
        return self.kind

    @model_validator(mode="after")
    def _room(self) -> Tumble:
        if self.time_s < 2.0 * self.run_in_s:
            raise ValueError(f"duration_s must be at least two run_in_s, {2.0 * self.run_in_s:g}")
        return self

    @property
    def duration_s(self) -> float:
        return self.time_s

    def reference(self, start: Start, t_s: Array) -> Array:
        envelope = window(t_s, self.duration_s, self.run_in_s)
        roll_rad, roll_phase = np.radians([self.roll_amplitude_deg, self.roll_phase_deg])
        pitch_rad, pitch_phase = np.radians([self.pitch_amplitude_deg, self.pitch_phase_deg])
        roll = envelope * sine(t_s, roll_rad, self.roll_period_s, roll_phase)
        pitch = envelope * sine(t_s, pitch_rad, self.pitch_period_s, pitch_phase)
        rate = np.radians(self.yaw_rate_deg_s)
        yaw = run(t_s, 0.0, rate, self.run_in_s, self.duration_s - self.run_in_s)
        return self.place(start, (yaw, pitch, roll), t_s)
