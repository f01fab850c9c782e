"""Noise of the sensor: white noise, Gauss-Markov noise, and flicker (1/f) noise as a sum of such processes."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Annotated

import numpy as np
from scipy.optimize import nnls

from scenarios.arrays import Array
from sim.effects.base import ZERO3, Effect, Memory, array, frozen
from sim.effects.kernels import kernel
from sim.effects.parameters import Quantity, Vec3
from sim.effects.traits import LONG_AT_REST, Traits
from sim.portable_arithmetic import extended, inverse, product
from sim.state import State

FLICKER_LOW_HZ = 1e-5
_POLES_A_DECADE = 2
_ZERO = 0.2


@frozen
class WhiteNoise(Effect):
    """White Gaussian noise, independent on each sample and axis: ``n ~ N(0, sigma^2)``."""

    name = "white_noise"
    stage = "sensor"
    stochastic = True
    example = {"std_nT": (5.0, 6.0, 7.0)}
    traits = Traits(remedy="average more samples", sign="white")

    std_nT: Annotated[
        Vec3, Quantity("nT", 0.0, 1e5, "sigma of a sample, axes x, y, z", role="level", per_axis=True)
    ] = ZERO3

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return rng.standard_normal((len(state), 3)) * array(self.std_nT)


def _flicker_density(f: Array, interval_s: float) -> Array:
    """Power density 1 / f in nT^2/Hz of flicker noise of 1 nT/sqrt(Hz) at 1 Hz, at f (m,) in Hz."""
    return np.asarray(1 / f)


@frozen
class FlickerNoise(Effect):
    """Flicker noise: one-sided power density ``d^2 / f`` in nT^2/Hz, from 1e-5 Hz to 0.45 of the sample rate.

    A bank of first-order processes, two a decade, whose sum follows 1/f within 3 % in the band; flat below the band,
    stationary from the first sample. The Allan deviation is about ``sqrt(2 ln 2) d`` at every averaging time.
    """

    name = "flicker_noise"
    stage = "sensor"
    stochastic = True
    example = {"density_nT_sqrt_hz": (1.0, 2.0, 3.0)}
    traits = Traits(
        experiment=LONG_AT_REST, remedy="calibrate more often, or choose a quieter sensor", spectrum=_flicker_density
    )

    density_nT_sqrt_hz: Annotated[
        Vec3, Quantity("nT/sqrt(Hz)", 0.0, 1e5, "d: the density at 1 Hz, axes x, y, z", role="level", per_axis=True)
    ] = ZERO3

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        decay, std = flicker_bank(state.interval_s)
        if not memory:
            memory["bank"] = rng.standard_normal((3, len(std))) * std
            memory["before"] = memory["bank"].sum(axis=1)
        kick = std * np.sqrt(1.0 - decay**2)
        unit = _bank(rng, len(state), memory["bank"], memory["before"], decay, kick)
        return unit * array(self.density_nT_sqrt_hz)


def _gauss_markov_density(f: Array, interval_s: float, correlation_time_s: float) -> Array:
    """``2 dt (1 - a^2) / (1 - 2 a cos(2 pi f dt) + a^2)``, ``a = exp(-dt / tau)``, of unit standard deviation."""
    a = math.exp(-interval_s / correlation_time_s)
    return np.asarray(2 * interval_s * (1 - a**2) / (1 - 2 * a * np.cos(2 * np.pi * f * interval_s) + a**2))


@frozen
class GaussMarkovNoise(Effect):
    """First-order Gauss-Markov noise: correlation ``sigma^2 exp(-|t| / tau)``, stationary from the first sample.

    An autoregressive process of first order, of the kind in [IEEE-952]; far beyond tau its mean is as uncertain as that
    of white noise.
    """

    name = "gauss_markov_noise"
    stage = "sensor"
    stochastic = True
    example = {"std_nT": (2.0, 3.0, 4.0), "correlation_time_s": 5.0}
    traits = Traits(
        experiment=LONG_AT_REST,
        remedy="average over many correlation times, or find what disturbs the sensor for so long",
        spectrum=_gauss_markov_density,
    )

    std_nT: Annotated[Vec3, Quantity("nT", 0.0, 1e5, "sigma of the axes x, y, z", role="level", per_axis=True)] = ZERO3
    correlation_time_s: Annotated[
        float, Quantity("s", 1e-3, 1e6, "tau", role="listed", tried=(0.3, 1.0, 3.0, 10.0, 30.0, 100.0))
    ] = 1.0

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        decay = math.exp(-state.interval_s / self.correlation_time_s)
        if not memory:
            memory["last"] = rng.standard_normal(3)
        unit = _markov(rng.standard_normal((len(state), 3)) * math.sqrt(1 - decay**2), memory["last"], decay)
        return unit * array(self.std_nT)


@kernel
def _markov(kicks: Array, last: Array, decay: float) -> Array:
    """``x_k = decay x_(k-1) + kick_k`` (n, 3) after `last` (3,), which becomes the last of them."""
    for i in range(len(kicks)):
        for j in range(3):
            last[j] = decay * last[j] + kicks[i, j]
            kicks[i, j] = last[j]
    return kicks


@lru_cache(maxsize=32)
def flicker_bank(interval_s: float) -> tuple[Array, Array]:
    """Decay per sample and standard deviation of each process, for unit density at 1 Hz and a sample interval.

    Non-negative least squares of (density of the sum) x f against 1; the zero of the moving average
    (x_k + 0.2 x_k-1) / 1.2 keeps the sampled density falling beyond a fifth of the sample rate.
    """
    rate = 1.0 / interval_s
    low, high = min(FLICKER_LOW_HZ, 1e-3 * rate), 0.45 * rate
    count = math.ceil(math.log10(20 * rate / low) * _POLES_A_DECADE)
    corners = np.geomspace(extended(low / 3), extended(3 * rate), count)
    f = np.geomspace(extended(low), extended(high), 400)
    decay = np.exp(-2 * np.pi * corners * interval_s)
    turn = np.cos(2 * np.pi * f * interval_s)[:, None]
    lorentzians = 2 * interval_s * (1 - decay**2) / (1 - 2 * decay * turn + decay**2)
    average = (1 + _ZERO**2 + 2 * _ZERO * turn) / (1 + _ZERO) ** 2
    share = lorentzians * average * f[:, None]
    used = nnls(share.astype(np.float64), np.ones(len(f)))[0] > 0
    # Solved again, as nnls's last bits depend on the processor; in extended precision, as slow processes cancel.
    basis = share[:, used]
    variance = product(inverse(product(basis.T, basis)), basis.sum(axis=0)[:, None])[:, 0]
    return decay[used].astype(np.float64), np.sqrt(variance).astype(np.float64)


@kernel
def _bank(rng: np.random.Generator, n: int, bank: Array, before: Array, decay: Array, kick: Array) -> Array:
    out = np.empty((n, 3))
    for i in range(n):
        for j in range(3):
            total = 0.0
            for k in range(len(decay)):
                bank[j, k] = decay[k] * bank[j, k] + kick[k] * rng.standard_normal()
                total += bank[j, k]
            out[i, j] = (total + _ZERO * before[j]) / (1.0 + _ZERO)
            before[j] = total
    return out
