"""The sensor's offset: constant, jump, random walk."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from scenarios.arrays import Array
from sim.effects.base import ZERO3, Effect, Memory, array, frozen
from sim.effects.parameters import Quantity, Vec3
from sim.effects.traits import IN_ITS_MOUNT, LONG_AT_REST, Traits
from sim.state import State


@frozen
class SensorOffset(Effect):
    """Constant offset of the sensor: ``b`` ([Long2013] eq. 1, b_o; [Ding2021] eq. 3)."""

    name = "sensor_offset"
    stage = "sensor"
    static = True
    example = {"offset_nT": (-10.0, 20.0, 30.0)}
    traits = Traits(
        experiment=IN_ITS_MOUNT,
        remedy="calibrate the offset on the vehicle as it will be used",
        absorbed=True,
        constant=True,
    )

    offset_nT: Annotated[Vec3, Quantity("nT", -1e6, 1e6, "b of the axes x, y, z", role="linear")] = ZERO3

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return np.tile(self.offset_nT, (len(state), 1))


@frozen
class OffsetJump(Effect):
    """Jump of the offset: ``b`` from time t_0 on."""

    name = "offset_jump"
    stage = "sensor"
    static = True
    example = {"time_s": 10.01, "step_nT": (50.0, -20.0, 10.0)}
    traits = Traits(
        experiment=LONG_AT_REST, remedy="calibrate each side of the jump by itself", one_run=True, whole_run=True
    )

    time_s: Annotated[float, Quantity("s", 0.0, 1e7, "t_0 since the start of the run", role="moment")] = 0.0
    step_nT: Annotated[Vec3, Quantity("nT", -1e6, 1e6, "b of the axes x, y, z", role="linear")] = ZERO3

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return (state.time_s >= self.time_s)[:, None] * array(self.step_nT)


def _walk_density(f: Array, interval_s: float) -> Array:
    """Power density 1 / (2 pi^2 f^2) in nT^2/Hz of a Wiener process of 1 nT/sqrt(s), at f (m,) in Hz."""
    return np.asarray(1 / (2 * np.pi**2 * f**2))


@frozen
class OffsetRandomWalk(Effect):
    """Random walk of the offset: a Wiener process, zero at the start, of standard deviation ``q sqrt(t)``.

    The Allan deviation is ``q sqrt(tau / 3)``.
    """

    name = "offset_random_walk"
    stage = "sensor"
    stochastic = True
    example = {"std_nT_sqrt_s": (2.0, 2.0, 2.0)}
    traits = Traits(
        experiment=LONG_AT_REST,
        remedy="calibrate more often, or estimate the offset as it goes",
        spectrum=_walk_density,
    )

    std_nT_sqrt_s: Annotated[
        Vec3, Quantity("nT/sqrt(s)", 0.0, 1e5, "q of the axes x, y, z", role="level", per_axis=True)
    ] = ZERO3

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        steps = rng.standard_normal((len(state), 3)) * (array(self.std_nT_sqrt_s) * math.sqrt(state.interval_s))
        # The sum is carried in the first step, so that it runs over the same numbers however the run is cut.
        steps[0] = steps[0] + memory["last"] if memory else 0.0
        walk = np.cumsum(steps, axis=0)
        memory["last"] = walk[-1].copy()
        return walk
