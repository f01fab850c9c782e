"""Fields of currents in the vehicle: eddy currents in its skin, supply currents of its motors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from scenarios.errors import InputError
from sim.effects.base import ZERO3, ZERO33, Effect, Mat3, Memory, Vec3, array, parameter
from sim.effects.kernels import first_order_lag, times
from sim.state import Array, State


@dataclass(frozen=True)
class EddyCurrent(Effect):
    """Field of the eddy currents that turning in the Earth's field induces: ``B dT/dt`` ([Li2017] eq. 1).

    With a time constant, behind a first-order lag (exact for a rate linear between samples, steady at the start):
    currents in a conductor with inductance do not follow at once.
    """

    name: ClassVar[str] = "eddy_current"
    stage: ClassVar[str] = "vehicle"
    needs: ClassVar[tuple[str, ...]] = ("rate",)
    linear: ClassVar[tuple[str, ...]] = ("matrix_s",)
    search: ClassVar[dict[str, tuple[float, ...]]] = {"time_constant_s": (0.0, 0.1, 0.3, 1.0, 3.0)}

    matrix_s: Mat3 = parameter(ZERO33, "s", -10.0, 10.0, "B, on the field's rate in the body frame (nT/s)")
    time_constant_s: float = parameter(0.0, "s", 0.0, 100.0, "lag of the currents; 0: none")

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        drive = times(array(self.matrix_s), state.field_rate_nT_s)
        if self.time_constant_s > 0:
            return first_order_lag(drive, self.time_constant_s, state.interval_s, memory)
        return drive


@dataclass(frozen=True)
class MotorCurrent(Effect):
    """Field of the motors' supply currents: ``g I(t)``."""

    name: ClassVar[str] = "motor_current"
    stage: ClassVar[str] = "vehicle"
    static: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("current",)
    linear: ClassVar[tuple[str, ...]] = ("gain_nT_A",)

    gain_nT_A: Vec3 = parameter(ZERO3, "nT/A", -1e5, 1e5, "g forward, left, up")
    motor: int = parameter(0, "", 0, 64, "which motor, from 1; 0: the sum of all")

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return _current(state, self.motor, self.name)[:, None] * array(self.gain_nT_A)


@dataclass(frozen=True)
class CurrentRipple(Effect):
    """Field of a supply current that pulses at a fixed frequency: ``a I(t) sin(2 pi f t + phi)``.

    A frequency above half the sample rate is aliased, as it is in a sampled instrument.
    """

    name: ClassVar[str] = "current_ripple"
    stage: ClassVar[str] = "vehicle"
    needs: ClassVar[tuple[str, ...]] = ("current",)
    linear: ClassVar[tuple[str, ...]] = ("amplitude_nT_A",)

    amplitude_nT_A: Vec3 = parameter(ZERO3, "nT/A", -1e5, 1e5, "a forward, left, up")
    frequency_hz: float = parameter(1.0, "Hz", 0.0, 1e5, "f")
    phase_deg: float = parameter(0.0, "deg", -360.0, 360.0, "phi at the start of the run")
    motor: int = parameter(0, "", 0, 64, "which motor, from 1; 0: the sum of all")

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        tone = np.sin((2 * math.pi * self.frequency_hz) * state.time_s + math.radians(self.phase_deg))
        return (_current(state, self.motor, self.name) * tone)[:, None] * array(self.amplitude_nT_A)


def _current(state: State, motor: int, name: str) -> Array:
    count = state.current_A.shape[1]
    if motor > count:
        found = f"motor {motor} asked for, the vehicle has {count}"
        raise InputError(found, where=f"effects.{name}.motor", do=f"give 1 to {count}, or 0 for the sum of all")
    chosen: Array = state.current_A[:, motor - 1] if motor else state.current_A.sum(axis=1)
    return chosen
