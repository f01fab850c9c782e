"""Delayed signals: low-pass of the sensor, latency of the values."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from scenarios.arrays import Array
from sim.effects.base import Memory, Replacement, frozen
from sim.effects.kernels import curved_lag
from sim.effects.parameters import Quantity
from sim.effects.resampling import respond_on_even_grid
from sim.effects.traits import AT_SEVERAL_RATES, LATE, Traits
from sim.state import State


@frozen
class Bandwidth(Replacement):
    """First-order low-pass ``H(f) = 1 / (1 + i f / f_c)``, exact for a signal of parabolas through three samples.

    Slow signals are delayed by 1 / (2 pi f_c) at any sample rate, also for f_c far above the sample rate.
    """

    name = "bandwidth"
    stage = "sensor"
    continuous = True
    example = {"cutoff_hz": 3.0}
    traits = Traits(
        experiment=AT_SEVERAL_RATES,
        remedy="turn more slowly, or raise the sensor's bandwidth",
        correlates_noise=True,
        family=LATE,
    )

    cutoff_hz: Annotated[
        float,
        Quantity(
            "Hz",
            0.0,
            1e9,
            "f_c, where the power is halved; 0: no low-pass",
            role="listed",
            tried=(0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0),
        ),
    ] = 0.0

    def replace(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        if self.cutoff_hz == 0:
            return signal_nT
        lag_s = 1 / (2 * math.pi * self.cutoff_hz)
        return respond_on_even_grid(state, signal_nT, lambda even: curved_lag(even, lag_s, state.interval_s, memory))


@frozen
class Latency(Replacement):
    """Latency of the values: ``s(t - d)``, a parabola through three samples; the first sample is held.

    With samples h apart a parabola errs by at most ``h^3 s''' / 16``, a line by ``h^2 s'' / 8``, as a low-pass does.
    Latency comes before noise and rounding: a late value has the noise of a single measurement, not of a mean of three,
    and interpolation would take the values off the converter's grid.
    """

    name = "latency"
    stage = "sensor"
    continuous = True
    example = {"delay_s": 0.11}
    traits = Traits(experiment=AT_SEVERAL_RATES, remedy="correct the time stamps", correlates_noise=True, family=LATE)

    delay_s: Annotated[
        float, Quantity("s", 0.0, 60.0, "d", role="listed", tried=(0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0))
    ] = 0.0

    def replace(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return respond_on_even_grid(state, signal_nT, lambda even: self._late(even, state.interval_s, memory))

    def _late(self, signal_nT: Array, interval_s: float, memory: Memory) -> Array:
        whole, x = divmod(self.delay_s / interval_s, 1.0)
        past = int(whole) + 2
        if not memory:
            memory["past"] = np.tile(signal_nT[0], (past, 1))
        history: Array = np.concatenate([memory["past"], signal_nT])
        memory["past"] = history[-past:].copy()
        n = len(signal_nT)
        older, old, late = history[:n], history[1 : n + 1], history[2 : n + 2]
        return (1 - x) * (2 - x) / 2 * late + x * (2 - x) * old - x * (1 - x) / 2 * older
