"""The vehicle's iron: induced and permanent magnetism, and permanent magnetism that changes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sim.effects.base import ZERO3, ZERO33, Effect, Mat3, Memory, Vec3, array, parameter
from sim.effects.kernels import times
from sim.state import Array, State


@dataclass(frozen=True)
class SoftIron(Effect):
    """Magnetism induced in the vehicle by the field: ``A s`` ([Li2017] eq. 1; [Long2013] C_s = I + A)."""

    name: ClassVar[str] = "soft_iron"
    stage: ClassVar[str] = "vehicle"
    static: ClassVar[bool] = True
    linear: ClassVar[tuple[str, ...]] = ("matrix",)

    matrix: Mat3 = parameter(ZERO33, "", -5.0, 5.0, "A, added to the identity")

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return times(array(self.matrix), signal_nT)


@dataclass(frozen=True)
class HardIron(Effect):
    """Permanent magnetism of the vehicle, constant in the body frame: ``h`` ([Li2017] eq. 1, T_p)."""

    name: ClassVar[str] = "hard_iron"
    stage: ClassVar[str] = "vehicle"
    static: ClassVar[bool] = True
    linear: ClassVar[tuple[str, ...]] = ("offset_nT",)

    offset_nT: Vec3 = parameter(ZERO3, "nT", -1e6, 1e6, "h forward, left, up")

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return np.tile(self.offset_nT, (len(state), 1))


@dataclass(frozen=True)
class HardIronDrift(Effect):
    """Permanent magnetism that changes in the run, zero at its start: ``r t``, or ``r tau (1 - exp(-t / tau))``.

    Shocks, pressure and temperature change a hull's magnetism; [Zhang2018] finds the ellipsoid moving in the run.
    """

    name: ClassVar[str] = "hard_iron_drift"
    stage: ClassVar[str] = "vehicle"
    static: ClassVar[bool] = True
    linear: ClassVar[tuple[str, ...]] = ("rate_nT_h",)
    search: ClassVar[dict[str, tuple[float, ...]]] = {"time_constant_s": (0.0, 100.0, 300.0, 1000.0)}

    rate_nT_h: Vec3 = parameter(ZERO3, "nT/h", -1e6, 1e6, "r at the start, forward, left, up")
    time_constant_s: float = parameter(0.0, "s", 0.0, 1e7, "tau with which it settles; 0: it does not settle")

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        tau = self.time_constant_s
        course_s = -tau * np.expm1(-state.time_s / tau) if tau > 0 else state.time_s
        return course_s[:, None] * (array(self.rate_nT_h) / 3600.0)
