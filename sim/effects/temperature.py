"""What the sensor's temperature changes: sensitivity and offset."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sim.effects.base import ZERO3, Effect, Memory, Vec3, array, parameter
from sim.state import Array, State


@dataclass(frozen=True)
class TemperatureScale(Effect):
    """Sensitivity that changes with temperature: ``k (T - T_ref) s`` on each axis."""

    name: ClassVar[str] = "temperature_scale"
    stage: ClassVar[str] = "sensor"
    static: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("temperature",)
    linear: ClassVar[tuple[str, ...]] = ("slope_1_K",)

    slope_1_K: Vec3 = parameter(ZERO3, "1/K", -0.05, 0.05, "k of the axes x, y, z", per_axis=True)
    reference_degC: float = parameter(20.0, "degC", -100.0, 200.0, "T_ref, where it contributes nothing")

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        excess = state.temperature_degC - self.reference_degC
        return signal_nT * excess[:, None] * array(self.slope_1_K)


@dataclass(frozen=True)
class TemperatureOffset(Effect):
    """Offset that changes with temperature: ``k (T - T_ref)``."""

    name: ClassVar[str] = "temperature_offset"
    stage: ClassVar[str] = "sensor"
    static: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("temperature",)
    linear: ClassVar[tuple[str, ...]] = ("slope_nT_K",)

    slope_nT_K: Vec3 = parameter(ZERO3, "nT/K", -1e4, 1e4, "k of the axes x, y, z")
    reference_degC: float = parameter(20.0, "degC", -100.0, 200.0, "T_ref, where it contributes nothing")

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return (state.temperature_degC - self.reference_degC)[:, None] * array(self.slope_nT_K)
