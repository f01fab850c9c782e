"""Temperature effects of the sensor: sensitivity and offset."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import numpy as np

from recordings.channels import TEMPERATURE
from scenarios.arrays import Array
from sim.effects.base import ZERO3, Effect, Memory, array, frozen
from sim.effects.kernels import first_order_lag
from sim.effects.parameters import Quantity, Vec3
from sim.effects.traits import WARM_AND_COOL, Traits
from sim.state import State

REFERENCE_DEGC = 20.0
LAGS_S = (0.0, 3.0, 10.0, 30.0, 100.0, 300.0)
CURVE, SECOND_LAG = "curve", "second lag"
CLUES = Traits(
    experiment=WARM_AND_COOL,
    remedy="log the temperature and take its part off, or let the sensor settle first",
    first_form=CURVE,
)
ReferenceTemperature = Annotated[
    float, Quantity("degC", -100.0, 200.0, "T_ref, where it contributes nothing", role="fixed")
]
Lag = Annotated[
    float,
    Quantity("s", 0.0, 1e5, "time constant with which the sensor follows T; 0: at once", role="listed", tried=LAGS_S),
]

SecondLag = Annotated[
    float,
    Quantity("s", 0.0, 1e5, "a second lag, behind the first", role="listed", tried=LAGS_S[1:], form=SECOND_LAG),
]


@frozen
class TemperatureScale(Effect):
    """Temperature dependence of the sensitivity: ``(k (T - T_ref) + k2 (T - T_ref)^2) s`` on each axis.

    T is the measured temperature behind one first-order lag, or two.
    """

    name = "temperature_scale"
    stage = "sensor"
    static = True
    needs = (TEMPERATURE,)
    example = {"slope_1_K": (1e-4, 2e-4, -3e-4), "reference_degC": 15.0, "square_1_K2": (2e-6, 1e-6, 3e-6)}
    traits = CLUES

    slope_1_K: Annotated[Vec3, Quantity("1/K", -0.05, 0.05, "k of the axes x, y, z", role="linear", per_axis=True)] = (
        ZERO3
    )
    reference_degC: ReferenceTemperature = REFERENCE_DEGC
    lag_s: Lag = 0.0
    square_1_K2: Annotated[
        Vec3, Quantity("1/K2", -0.05, 0.05, "k2 of the axes x, y, z", role="linear", per_axis=True, form=CURVE)
    ] = ZERO3
    second_lag_s: SecondLag = 0.0

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        warmer_K = _felt_degC(state, (self.lag_s, self.second_lag_s), memory) - self.reference_degC
        return signal_nT * _curve(warmer_K, self.slope_1_K, self.square_1_K2)

    @classmethod
    def central_reference(cls, state: State) -> dict[str, float]:
        return _middle(state)

    def convention_columns(self, state: State, signal_nT: Array) -> Array:
        """Scale on each axis: a different reference temperature."""
        return signal_nT[:, :, None] * np.stack([array(self.slope_1_K), array(self.square_1_K2)], axis=1)


@frozen
class TemperatureOffset(Effect):
    """Temperature dependence of the offset: ``k (T - T_ref) + k2 (T - T_ref)^2``, T behind one lag, or two."""

    name = "temperature_offset"
    stage = "sensor"
    static = True
    needs = (TEMPERATURE,)
    example = {"slope_nT_K": (1.0, -2.0, 3.0), "square_nT_K2": (0.1, 0.2, -0.1), "lag_s": 20.0, "second_lag_s": 5.0}
    traits = replace(CLUES, slow=True)

    slope_nT_K: Annotated[Vec3, Quantity("nT/K", -1e4, 1e4, "k of the axes x, y, z", role="linear")] = ZERO3
    reference_degC: ReferenceTemperature = REFERENCE_DEGC
    lag_s: Lag = 0.0
    square_nT_K2: Annotated[Vec3, Quantity("nT/K2", -1e4, 1e4, "k2 of the axes x, y, z", role="linear", form=CURVE)] = (
        ZERO3
    )
    second_lag_s: SecondLag = 0.0

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        warmer_K = _felt_degC(state, (self.lag_s, self.second_lag_s), memory) - self.reference_degC
        return _curve(warmer_K, self.slope_nT_K, self.square_nT_K2)

    @classmethod
    def central_reference(cls, state: State) -> dict[str, float]:
        return _middle(state)

    def convention_columns(self, state: State, signal_nT: Array) -> Array:
        """Constant on each axis: a different reference temperature."""
        return np.tile(np.stack([array(self.slope_nT_K), array(self.square_nT_K2)], axis=1), (len(state), 1, 1))


def _middle(state: State) -> dict[str, float]:
    """Mean temperature of a recording as reference, to a tenth of a degree."""
    return {"reference_degC": round(float(np.mean(state.channel(TEMPERATURE))), 1)}


def _curve(warmer_K: Array, slope: Vec3, square: Vec3) -> Array:
    """``k dT + k2 dT^2`` (n, 3) of a difference of temperature (n, 1), the square where it is in use."""
    course = warmer_K * array(slope)
    return course + warmer_K**2 * array(square) if any(square) else course


def _felt_degC(state: State, lags_s: tuple[float, ...], memory: Memory) -> Array:
    """Temperature (n, 1) of a sensor behind the measured temperature by first-order lags, at rest at the start."""
    felt_degC = state.channel(TEMPERATURE)[:, None]
    for i, lag_s in enumerate(lags_s):
        if lag_s > 0:
            felt_degC = first_order_lag(felt_degC, lag_s, state.interval_s, memory.setdefault(f"lag {i}", {}))
    return felt_degC
