"""Rare failures of the electronics: single wrong values, and repeated values."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from scenarios.arrays import Array
from sim.effects.base import Effect, Memory, Replacement, frozen
from sim.effects.kernels import kernel
from sim.effects.parameters import Quantity
from sim.effects.traits import Traits
from sim.state import State

LEAST_RATE_HZ = 1e-30
"""Rate of an event below which none comes in any run; its reciprocal may be no number."""


@frozen
class Spikes(Effect):
    """Single wrong values at Poisson moments, on a random axis.

    The size has a random sign and an exponential magnitude of mean A: a Laplace distribution of standard deviation
    ``sqrt(2) A``. A moment between two samples falls on the earlier sample.
    """

    name = "spikes"
    stage = "electronics"
    stochastic = True
    example = {"rate_hz": 2.0, "amplitude_nT": 300.0}
    traits = Traits(remedy="leave the wrong samples out", sign="outliers")

    rate_hz: Annotated[float, Quantity("Hz", 0.0, 1e3, "mean number a second")] = 0.0
    amplitude_nT: Annotated[float, Quantity("nT", 0.0, 1e7, "mean magnitude A", role="level")] = 0.0

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        if self.rate_hz < LEAST_RATE_HZ:
            return np.zeros((len(state), 3))
        gap = 1.0 / (self.rate_hz * state.interval_s)
        if not memory:
            memory["wait"] = np.array([rng.exponential(gap)])
        return _spikes(rng, len(state), memory["wait"], gap, self.amplitude_nT)


@frozen
class Dropouts(Replacement):
    """Gaps in which the electronics repeats the last value on all axes.

    Times between gaps and lengths of gaps are exponential; the share of repeated samples is ``d / (d + 1 / rate)``.
    """

    name = "dropouts"
    stage = "electronics"
    stochastic = True
    example = {"rate_hz": 1.0, "mean_duration_s": 0.2}
    traits = Traits(remedy="leave the repeated samples out", sign="repeats")

    rate_hz: Annotated[float, Quantity("Hz", 0.0, 1e3, "mean number in a second of work")] = 0.0
    mean_duration_s: Annotated[float, Quantity("s", 0.0, 1e5, "mean length d")] = 0.1

    def replace(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        if self.rate_hz < LEAST_RATE_HZ or self.mean_duration_s == 0:
            return signal_nT
        means = np.array([1.0 / self.rate_hz, self.mean_duration_s]) / state.interval_s
        if not memory:
            memory["last"] = signal_nT[0].copy()
            memory["clock"] = np.array([0.0, rng.exponential(means[0])])
        return _hold(rng, signal_nT, memory["last"], memory["clock"], means)


@kernel
def _spikes(rng: np.random.Generator, n: int, wait: Array, gap: float, amplitude: float) -> Array:
    out = np.zeros((n, 3))
    for i in range(n):
        while wait[0] < 1.0:
            axis = int(3.0 * rng.random())
            sign = 1.0 if rng.random() < 0.5 else -1.0
            out[i, axis] += sign * amplitude * rng.standard_exponential()
            wait[0] += gap * rng.standard_exponential()
        wait[0] -= 1.0
    return out


@kernel
def _hold(rng: np.random.Generator, signal: Array, last: Array, clock: Array, means: Array) -> Array:
    """Repeat the last value in gaps; clock: 0 at work or 1 in a gap, and sample intervals until the next change."""
    out = np.empty_like(signal)
    for i in range(len(signal)):
        while clock[1] <= 0.0:
            clock[0] = 1.0 - clock[0]
            clock[1] += means[int(clock[0])] * rng.standard_exponential()
        for j in range(3):
            if clock[0] == 0.0:
                last[j] = signal[i, j]
            out[i, j] = last[j]
        clock[1] -= 1.0
    return out
