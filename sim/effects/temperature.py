"""What the sensor's temperature changes: sensitivity and offset."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sim.effects.base import ZERO3, Effect, Memory, Vec3, array, parameter
from sim.effects.kernels import first_order_lag
from sim.state import Array, State

LAGS_S = (0.0, 3.0, 10.0, 30.0, 100.0, 300.0)


@dataclass(frozen=True)
class TemperatureScale(Effect):
    """Sensitivity that changes with temperature: ``k (T - T_ref) s`` on each axis, T felt late by a lag."""

    name: ClassVar[str] = "temperature_scale"
    stage: ClassVar[str] = "sensor"
    static: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("temperature",)
    linear: ClassVar[tuple[str, ...]] = ("slope_1_K",)
    search: ClassVar[dict[str, tuple[float, ...]]] = {"lag_s": LAGS_S}

    slope_1_K: Vec3 = parameter(ZERO3, "1/K", -0.05, 0.05, "k of the axes x, y, z", per_axis=True)
    reference_degC: float = parameter(20.0, "degC", -100.0, 200.0, "T_ref, where it contributes nothing")
    lag_s: float = parameter(0.0, "s", 0.0, 1e5, "time constant with which the sensor follows T; 0: at once")

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return signal_nT * (_felt_degC(state, self.lag_s, memory) - self.reference_degC) * array(self.slope_1_K)


@dataclass(frozen=True)
class TemperatureOffset(Effect):
    """Offset that changes with temperature: ``k (T - T_ref)``, T felt late by a lag."""

    name: ClassVar[str] = "temperature_offset"
    stage: ClassVar[str] = "sensor"
    static: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("temperature",)
    linear: ClassVar[tuple[str, ...]] = ("slope_nT_K",)
    search: ClassVar[dict[str, tuple[float, ...]]] = {"lag_s": LAGS_S}

    slope_nT_K: Vec3 = parameter(ZERO3, "nT/K", -1e4, 1e4, "k of the axes x, y, z")
    reference_degC: float = parameter(20.0, "degC", -100.0, 200.0, "T_ref, where it contributes nothing")
    lag_s: float = parameter(0.0, "s", 0.0, 1e5, "time constant with which the sensor follows T; 0: at once")

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return (_felt_degC(state, self.lag_s, memory) - self.reference_degC) * array(self.slope_nT_K)


def _felt_degC(state: State, lag_s: float, memory: Memory) -> Array:
    """Temperature (n, 1) of a sensor that follows the measured one with a first-order lag, at rest at the start."""
    measured_degC = state.temperature_degC[:, None]
    return measured_degC if lag_s == 0 else first_order_lag(measured_degC, lag_s, state.interval_s, memory)
