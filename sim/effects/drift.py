"""The sensor's own offset: constant, jumping, wandering."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sim.effects.base import ZERO3, Effect, Memory, Vec3, array, parameter
from sim.state import Array, State


@dataclass(frozen=True)
class SensorOffset(Effect):
    """Constant offset of the sensor: ``b`` ([Long2013] eq. 1, b_o; [Ding2021] eq. 3)."""

    name: ClassVar[str] = "sensor_offset"
    stage: ClassVar[str] = "sensor"
    static: ClassVar[bool] = True
    linear: ClassVar[tuple[str, ...]] = ("offset_nT",)

    offset_nT: Vec3 = parameter(ZERO3, "nT", -1e6, 1e6, "b of the axes x, y, z")

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return np.tile(self.offset_nT, (len(state), 1))


@dataclass(frozen=True)
class OffsetJump(Effect):
    """Offset that jumps once: ``b`` from time t_0 on."""

    name: ClassVar[str] = "offset_jump"
    stage: ClassVar[str] = "sensor"
    static: ClassVar[bool] = True
    linear: ClassVar[tuple[str, ...]] = ("step_nT",)

    time_s: float = parameter(0.0, "s", 0.0, 1e7, "t_0 since the start of the run")
    step_nT: Vec3 = parameter(ZERO3, "nT", -1e6, 1e6, "b of the axes x, y, z")

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return (state.time_s >= self.time_s)[:, None] * array(self.step_nT)


@dataclass(frozen=True)
class OffsetRandomWalk(Effect):
    """Offset that wanders: a Wiener process, zero at the start, of standard deviation ``q sqrt(t)``.

    Its Allan deviation is ``q sqrt(tau / 3)``.
    """

    name: ClassVar[str] = "offset_random_walk"
    stage: ClassVar[str] = "sensor"
    stochastic: ClassVar[bool] = True

    std_nT_sqrt_s: Vec3 = parameter(ZERO3, "nT/sqrt(s)", 0.0, 1e5, "q of the axes x, y, z", per_axis=True)

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        steps = rng.standard_normal((len(state), 3)) * (array(self.std_nT_sqrt_s) * math.sqrt(state.interval_s))
        # The sum is carried in the first step, so that it runs over the same numbers however the run is cut.
        steps[0] = steps[0] + memory["last"] if memory else 0.0
        walk = np.cumsum(steps, axis=0)
        memory["last"] = walk[-1].copy()
        return walk
