"""The vehicle's iron: induced magnetism, permanent magnetism, drift of the permanent magnetism."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from scenarios.arrays import Array
from sim.effects.base import ZERO3, ZERO33, Effect, Memory, array, frozen
from sim.effects.kernels import times
from sim.effects.parameters import Mat3, Quantity, Vec3
from sim.effects.traits import IN_ITS_MOUNT, WARM_AND_COOL, Traits
from sim.portable_arithmetic import extended
from sim.state import State


@frozen
class SoftIron(Effect):
    """Magnetism induced in the vehicle by the field: ``A s`` ([Li2017] eq. 1; [Long2013] C_s = I + A)."""

    name = "soft_iron"
    stage = "vehicle"
    static = True
    example = {"matrix": ((0.1, 0.01, 0.02), (-0.03, 0.05, 0.03), (0.04, 0.01, 0.02))}
    traits = Traits(
        experiment=IN_ITS_MOUNT, remedy="calibrate the matrix on the vehicle as it will be used", absorbed=True
    )

    matrix: Annotated[Mat3, Quantity("", -5.0, 5.0, "A, added to the identity", role="linear")] = ZERO33

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return times(array(self.matrix), signal_nT)


@frozen
class HardIron(Effect):
    """Permanent magnetism of the vehicle, constant in the body frame: ``h`` ([Li2017] eq. 1, T_p)."""

    name = "hard_iron"
    stage = "vehicle"
    static = True
    example = {"offset_nT": (100.0, -200.0, 300.0)}
    traits = Traits(
        experiment=IN_ITS_MOUNT,
        remedy="calibrate the offset on the vehicle as it will be used",
        absorbed=True,
        constant=True,
    )

    offset_nT: Annotated[Vec3, Quantity("nT", -1e6, 1e6, "h forward, left, up", role="linear")] = ZERO3

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return np.tile(self.offset_nT, (len(state), 1))


@frozen
class HardIronDrift(Effect):
    """Drift of the permanent magnetism, zero at the start: ``r t``, or ``r tau (1 - exp(-t / tau))``.

    Shocks, pressure and temperature change a hull's magnetism; [Zhang2018] finds the ellipsoid moving in the run.
    """

    name = "hard_iron_drift"
    stage = "vehicle"
    static = True
    example = {"rate_nT_h": (100.0, -300.0, 500.0), "time_constant_s": 100.0}
    traits = Traits(
        experiment=WARM_AND_COOL, remedy="calibrate again, close to the time of use", slow=True, whole_run=True
    )

    rate_nT_h: Annotated[Vec3, Quantity("nT/h", -1e6, 1e6, "r at the start, forward, left, up", role="linear")] = ZERO3
    time_constant_s: Annotated[
        float,
        Quantity(
            "s",
            0.0,
            1e7,
            "tau with which it settles; 0: it does not settle",
            role="listed",
            tried=(0.0, 100.0, 300.0, 1000.0),
        ),
    ] = 0.0

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        tau = self.time_constant_s
        course_s = _settled_s(state.time_s, tau) if tau > 0 else state.time_s
        return course_s[:, None] * (array(self.rate_nT_h) / 3600.0)

    def convention_columns(self, state: State, signal_nT: Array) -> Array:
        """Constant on each axis: a different time without contribution, such as the time of the calibration."""
        return np.tile(array(self.rate_nT_h)[:, None], (len(state), 1, 1))


def _settled_s(time_s: Array, tau_s: float) -> Array:
    """tau (1 - exp(-t / tau))."""
    return np.asarray(-tau_s * np.expm1(extended(-time_s / tau_s)), dtype=np.float64)
