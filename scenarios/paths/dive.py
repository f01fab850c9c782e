"""Unpowered descent and ascent by ballast, without guidance."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from scenarios.arrays import Array
from scenarios.paths.base import Ability, PhaseBase, Start
from scenarios.paths.jet import assemble, constant


class Dive(PhaseBase):
    """An unpowered change of depth; a force along the vertical acts trim_m ahead of the centre of gravity."""

    needs: ClassVar[Ability] = Ability.DIVE
    powered: ClassVar[bool] = False
    tracked: ClassVar[bool] = False
    max_duration_s: float = Field(10_800.0, gt=0, le=86_400, description="the latest end of the phase")
    trim_m: float = Field(0.1, ge=-1, le=1, description="lever arm of the ballast ahead of the centre of gravity")

    @property
    def duration_s(self) -> float:
        return self.max_duration_s

    @property
    def settle_s(self) -> float:
        """The whole phase: nothing is tracked."""
        return self.max_duration_s

    def reference(self, start: Start, t_s: Array) -> Array:
        """Return the position and heading at the start of the phase, level; no thrust follows the reference."""
        east, north, up = (constant(p, t_s) for p in start.pos_enu_m)
        level = constant(0.0, t_s)
        return assemble((east, north, up), constant(start.yaw_rad, t_s), level, level)


class Descent(Dive):
    """Sinks under ballast to a depth; the weight ahead of the centre turns the nose down."""

    kind: Literal["descent"]
    to_depth_m: float = Field(gt=0, le=11_000)
    net_weight_N: float = Field(40.0, gt=0, le=2000, description="weight of the ballast in water")

    @property
    def end_depth_m(self) -> float:
        return self.to_depth_m

    @property
    def ballast_N(self) -> float:
        """Downward force of the ballast."""
        return self.net_weight_N


class Ascent(Dive):
    """Rises to a depth after the ballast is dropped; the buoyancy ahead of the centre turns the nose up."""

    kind: Literal["ascent"]
    to_depth_m: float = Field(5.0, ge=0, le=11_000)
    net_buoyancy_N: float = Field(40.0, gt=0, le=2000)

    @property
    def end_depth_m(self) -> float:
        return self.to_depth_m

    @property
    def ballast_N(self) -> float:
        """Downward force of the ballast, negative: buoyancy."""
        return -self.net_buoyancy_N
