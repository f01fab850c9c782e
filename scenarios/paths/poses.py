"""Sequences of attitudes: held on the spot, or by pushes to and fro for a vehicle that cannot hold a tilt."""

from __future__ import annotations

import math
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from scenarios.arrays import Array
from scenarios.paths.base import LEAST_RAMP_S, Ability, Start
from scenarios.paths.excited import RunIn
from scenarios.paths.hover import GRAVITY_M_S2, at_rest
from scenarios.paths.jet import Jet, assemble, constant, pushed, smoothstep
from scenarios.paths.swaying import Swaying
from scenarios.table import Table


class Pose(Table):
    """An attitude Rz(yaw) Ry(pitch) Rx(roll), with the times to turn there and to hold."""

    yaw_deg: float = Field(ge=-360, le=360, description="from east, counter-clockwise; reached by the shorter turn")
    pitch_deg: float = Field(0.0, ge=-90, le=90)
    roll_deg: float = Field(0.0, ge=-180, le=180)
    move_s: float = Field(10.0, ge=LEAST_RAMP_S, le=3600)
    hold_s: float = Field(10.0, ge=0, le=86_400)


class Poses(RunIn):
    """Comes to rest, then turns to each attitude and holds it; level at the end.

    angle(t) = start + sum_i (angle_i - angle_(i-1)) smoothstep((t - t_i) / move_i)   for yaw, pitch and roll.
    """

    kind: Literal["poses"]
    needs: ClassVar[Ability] = Ability.TILT
    poses: tuple[Pose, ...] = Field(
        min_length=1, max_length=1000, description="tables with yaw_deg, pitch_deg, roll_deg, move_s, hold_s"
    )
    home_s: float = Field(10.0, ge=LEAST_RAMP_S, le=3600, description="turning level again, at the end")
    run_in_s: float = Field(5.0, ge=LEAST_RAMP_S, le=600)

    @property
    def duration_s(self) -> float:
        return sum(pose.move_s + pose.hold_s for pose in self.poses) + self.home_s

    def reference(self, start: Start, t_s: Array) -> Array:
        begin_deg = np.array([math.degrees(start.yaw_rad), 0.0, 0.0])
        angles, at_s, before = [constant(value, t_s) for value in np.radians(begin_deg)], 0.0, begin_deg
        home = Pose(yaw_deg=self.poses[-1].yaw_deg, move_s=self.home_s)
        for pose in (*self.poses, home):
            turned = np.array([pose.yaw_deg, pose.pitch_deg, pose.roll_deg]) - before
            turned[0] = nearest(turned[0])
            step = smoothstep(t_s - at_s, pose.move_s)
            angles = [angle + step * by for angle, by in zip(angles, np.radians(turned), strict=True)]
            at_s, before = at_s + pose.move_s + pose.hold_s, before + turned
        yaw, pitch, roll = angles
        return assemble(at_rest(start, t_s, self.run_in_s), yaw, pitch, roll)


class Push(Table):
    """An attitude for half of the time of a push to and fro, and the mirrored attitude for the other half."""

    yaw_deg: float = Field(ge=-360, le=360, description="from east, counter-clockwise; reached by the shorter turn")
    pitch_deg: float = Field(0.0, ge=-45, le=45)
    roll_deg: float = Field(0.0, ge=-45, le=45)
    times: int = Field(1, ge=1, le=1000, description="to and fro, four push_s each")
    turn_s: float | None = Field(
        None, ge=0.5, le=60, description="time to turn to the heading; default: turn_s of the phase"
    )

    @property
    def acceleration_m_s2(self) -> Array:
        """The acceleration east and north (2,): g b_xy / b_z, b the body's z axis."""
        yaw, pitch, roll = np.radians([self.yaw_deg, self.pitch_deg, self.roll_deg])
        ahead, left = math.tan(pitch), -math.tan(roll) / math.cos(pitch)
        cos, sin = math.cos(yaw), math.sin(yaw)
        return GRAVITY_M_S2 * np.array([ahead * cos - left * sin, ahead * sin + left * cos])


class Pushes(RunIn):
    """Accelerates to and fro by even pushes, which tilt the vehicle; turns to the next heading between pushes.

    a(t) is + a for push_s, - a for 2 push_s, + a for 2 push_s, ..., with changes by a smoothstep over switch_s: the
    vehicle is back in place, at rest, after `times` of four push_s. Against a drag the push, and with it the tilt, is
    + a or - a, and the vehicle gains less speed.
    """

    kind: Literal["pushes"]
    needs: ClassVar[Ability] = Ability.SWAY
    pushes: tuple[Push, ...] = Field(
        min_length=1, max_length=1000, description="tables with yaw_deg, pitch_deg, roll_deg, times, turn_s"
    )
    push_s: float = Field(1.5, ge=0.5, le=10, description="half of the time of one tilt")
    switch_s: float = Field(0.6, ge=0.3, le=2, description="from one tilt to its mirror")
    turn_s: float = Field(1.5, ge=0.5, le=60, description="turning to the next heading")
    drag_1_m: float = Field(0, ge=0, le=1, description="drag over mass and square of speed, against which is pushed")
    run_in_s: float = Field(5.0, ge=LEAST_RAMP_S, le=600)

    @property
    def duration_s(self) -> float:
        return self.run_in_s + sum(self.length_s(push) for push in self.pushes)

    def length_s(self, push: Push) -> float:
        """Return the time of a push: turn to the heading, pushes, and last switch."""
        sway = self._against_drag(push)
        swaying_s = 4.0 * push.times * self.push_s + self.switch_s if sway is None else sway.lasts_s(push.times)
        return self.turning_s(push) + swaying_s

    def turning_s(self, push: Push) -> float:
        """Return the time of the turn to a push's heading."""
        return self.turn_s if push.turn_s is None else push.turn_s

    def reference(self, start: Start, t_s: Array) -> Array:
        east, north, up = at_rest(start, t_s, self.run_in_s)
        yaw, at_s = constant(start.yaw_rad, t_s), self.run_in_s
        before = math.degrees(start.yaw_rad)
        for push in self.pushes:
            turned = nearest(push.yaw_deg - before)
            turn_s = self.turning_s(push)
            yaw = yaw + smoothstep(t_s - at_s, turn_s) * math.radians(turned)
            ahead, along = push.acceleration_m_s2, self._against_drag(push)
            if along is None:
                sway = self._to_and_fro(t_s - at_s - turn_s, push.times)
            else:
                sway = along.way(t_s - at_s - turn_s, push.times) * (1.0 / along.push_m_s2)
            east, north = east + sway * float(ahead[0]), north + sway * float(ahead[1])
            at_s, before = at_s + self.length_s(push), before + turned
        level = constant(0.0, t_s)
        return assemble((east, north, up), yaw, level, level)

    def _against_drag(self, push: Push) -> Swaying | None:
        """Return the motion of a push against drag; None without drag or acceleration."""
        size = float(np.hypot(*push.acceleration_m_s2))
        return Swaying(size, self.drag_1_m, self.push_s, self.switch_s) if self.drag_1_m > 0 and size > 0 else None

    def _to_and_fro(self, t_s: Array, times: int) -> Jet:
        """Return way, velocity and acceleration of unit pushes; zero before and after."""
        inside = np.clip(t_s, 0.0, 4.0 * times * self.push_s + self.switch_s)
        way = pushed(inside, self.switch_s) + pushed(inside - 4.0 * times * self.push_s, self.switch_s) * -1.0
        for number in range(2 * times):
            way = way + pushed(inside - (2 * number + 1) * self.push_s, self.switch_s) * (2.0 if number % 2 else -2.0)
        return way


def nearest(turn_deg: float) -> float:
    """Return a turn by the shorter way, -180 to 180."""
    return (turn_deg + 180.0) % 360.0 - 180.0
