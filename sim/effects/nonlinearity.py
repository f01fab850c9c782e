"""Nonlinear characteristics of a sensor: curvature and hysteresis."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated

import numpy as np

from scenarios.arrays import Array
from sim.effects.base import ZERO3, Effect, Memory, array, frozen
from sim.effects.kernels import kernel
from sim.effects.parameters import Quantity, Vec3
from sim.effects.traits import AT_SEVERAL_RATES, Traits
from sim.state import State

SHARPER, KINK = "higher orders", "kink"
SECOND_PLAY, THIRD_PLAY, ROUNDED = "second play", "third play", "rounded loop"
PLAYS_NT = (100.0, 300.0, 1000.0, 3000.0, 10_000.0, 30_000.0, 100_000.0)


@frozen
class Nonlinearity(Effect):
    """Curvature of the characteristic: ``F (c2 (s/F)^2 + ... + c5 (s/F)^5) + k |s|`` on each axis, F the reference.

    k : half of the difference between the slopes on both sides of zero.
    """

    name = "nonlinearity"
    stage = "sensor"
    static = True
    example = {"second_order": (1e-3, 2e-3, -1e-3), "third_order": (2e-3, 2e-3, 2e-3), "kink": (1e-3, 0.0, 2e-3)}
    traits = Traits(
        experiment="turn the sensor about all axes, so that each sees the whole field",
        remedy="measure the characteristic in a coil, or use a sensor with feedback",
    )

    second_order: Annotated[Vec3, Quantity("", -1.0, 1.0, "c2 of the axes x, y, z", role="linear", per_axis=True)] = (
        ZERO3
    )
    third_order: Annotated[Vec3, Quantity("", -1.0, 1.0, "c3 of the axes x, y, z", role="linear", per_axis=True)] = (
        ZERO3
    )
    reference_nT: Annotated[
        float, Quantity("nT", 1.0, 1e7, "F, at which the error is (c2 + ... + c5) F", role="fixed")
    ] = 50_000.0
    fourth_order: Annotated[
        Vec3, Quantity("", -1.0, 1.0, "c4 of the axes x, y, z", role="linear", per_axis=True, form=SHARPER)
    ] = ZERO3
    fifth_order: Annotated[
        Vec3, Quantity("", -1.0, 1.0, "c5 of the axes x, y, z", role="linear", per_axis=True, form=SHARPER)
    ] = ZERO3

    kink: Annotated[Vec3, Quantity("", -1.0, 1.0, "k of the axes x, y, z", role="linear", per_axis=True, form=KINK)] = (
        ZERO3
    )

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        ratio = signal_nT / self.reference_nT
        higher = array(self.third_order) + ratio * (array(self.fourth_order) + ratio * array(self.fifth_order))
        return signal_nT * ratio * (array(self.second_order) + ratio * higher) + np.abs(signal_nT) * array(self.kink)

    def convention_columns(self, state: State, signal_nT: Array) -> Array:
        """Slope and zero of the line from which the curvature is counted."""
        return _slopes_and_zeros(signal_nT, self.reference_nT)


def _slopes_and_zeros(signal_nT: Array, reference_nT: float) -> Array:
    """Columns (n, 3, 6): a slope and a constant on each axis."""
    zeros = np.tile(reference_nT * np.eye(3), (len(signal_nT), 1, 1))
    return np.concatenate([signal_nT[:, :, None] * np.eye(3), zeros], axis=2)


def _further_gain(whose: str, form: str) -> Quantity:
    """The gain of a further loop."""
    return Quantity("", -1.0, 1.0, f"g of {whose}", role="linear", per_axis=True, form=form)


def _further_threshold(whose: str, form: str) -> Quantity:
    """The half-width of a further loop."""
    return Quantity("nT", 1e-3, 1e6, f"r of {whose}", role="listed", tried=PLAYS_NT, form=form)


@frozen
class Hysteresis(Effect):
    """Lag of the core's magnetisation behind the signal: ``-g E_r(s)``, E_r the stop operator.

    ``e_k = clip(e_k-1 + s_k - s_k-1, -r, r)``, e = 0 at the start, on each axis: the signal minus a play of half-width
    r. Plays add up, ``-sum_j g_j E_rj(s)``, a Prandtl-Ishlinskii model; several thresholds of the first play share one
    gain, applied to the mean of the stops. A rounded loop ``-g D_r(s)``, ``dD = ds - |ds| D / r``, turns smoothly,
    where a play has a corner; the initial magnetisation decays as ``b exp(-w / r)``, w the path length of the signal.
    """

    name = "hysteresis"
    stage = "sensor"
    continuous = True
    example = {
        "gain": (0.02, 0.01, 0.03),
        "threshold_nT": (200.0, 3000.0),
        "second_gain": (0.01, 0.02, -0.01),
        "second_threshold_nT": 9000.0,
        "third_gain": (0.004, 0.002, 0.003),
        "third_threshold_nT": 500.0,
        "rounded_gain": (0.003, -0.002, 0.005),
        "rounded_threshold_nT": 4000.0,
        "rounded_start_nT": (4.0, -3.0, 6.0),
    }
    traits = Traits(
        experiment=AT_SEVERAL_RATES,
        remedy="bias or degauss the core, or use a sensor with feedback",
        first_form=ROUNDED,
    )

    gain: Annotated[Vec3, Quantity("", -1.0, 1.0, "g of the axes x, y, z", role="linear", per_axis=True)] = ZERO3
    threshold_nT: Annotated[
        float | tuple[float, ...],
        Quantity("nT", 1e-3, 1e6, "half-width r of the play, or several", role="listed", tried=PLAYS_NT),
    ] = 1000.0
    second_gain: Annotated[Vec3, _further_gain("a second play", SECOND_PLAY)] = ZERO3
    second_threshold_nT: Annotated[float, _further_threshold("the second play", SECOND_PLAY)] = 1000.0
    third_gain: Annotated[Vec3, _further_gain("a third play", THIRD_PLAY)] = ZERO3
    third_threshold_nT: Annotated[float, _further_threshold("the third play", THIRD_PLAY)] = 1000.0
    rounded_gain: Annotated[Vec3, _further_gain("a rounded loop", ROUNDED)] = ZERO3
    rounded_threshold_nT: Annotated[float, _further_threshold("the rounded loop", ROUNDED)] = 1000.0
    rounded_start_nT: Annotated[
        Vec3, Quantity("nT", -1e5, 1e5, "b, what it adds at the start", role="linear", per_axis=True, form=ROUNDED)
    ] = ZERO3

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        plays = [(g, r) for g, r in self._plays() if any(g)]
        gains = np.concatenate([np.zeros((0, 3)), *(np.tile(array(g) / len(r), (len(r), 1)) for g, r in plays)])
        thresholds = np.concatenate([np.zeros(0), *(r for _, r in plays)])
        if not memory:
            memory["before"], memory["stops"] = signal_nT[0].copy(), np.zeros((len(thresholds), 3))
            memory["last"], memory["rounded"] = signal_nT[0].copy(), np.zeros(3)
            memory["left_at"], memory["way"] = signal_nT[0].copy(), np.zeros(3)
        out = _stops(signal_nT, memory["before"], memory["stops"], thresholds, -gains)
        return self._with_rounded_loop(out, signal_nT, memory)

    def convention_columns(self, state: State, signal_nT: Array) -> Array:
        """Slope and zero from which a loop is counted: a play is the signal minus a stop."""
        return _slopes_and_zeros(signal_nT, float(np.max(self.threshold_nT)))

    def _with_rounded_loop(self, out: Array, signal_nT: Array, memory: Memory) -> Array:
        if any(self.rounded_gain):
            loop = _rounded(signal_nT, memory["last"], memory["rounded"], self.rounded_threshold_nT)
            out -= loop * array(self.rounded_gain)
        if any(self.rounded_start_nT):
            way = _way(signal_nT, memory)
            out += np.exp(-way / self.rounded_threshold_nT) * array(self.rounded_start_nT)
        return out

    def _plays(self) -> Iterator[tuple[Vec3, Array]]:
        """Gain and thresholds (m,) of each play."""
        yield self.gain, np.atleast_1d(array(self.threshold_nT))
        yield self.second_gain, np.atleast_1d(array(self.second_threshold_nT))
        yield self.third_gain, np.atleast_1d(array(self.third_threshold_nT))


@kernel
def _stops(signal: Array, before: Array, stops: Array, thresholds: Array, weights: Array) -> Array:
    """Sum over plays k of weights (k, 3) times the stops (k, 3) of a signal (n, 3)."""
    out = np.empty_like(signal)
    for i in range(len(signal)):
        for j in range(3):
            step = signal[i, j] - before[j]
            before[j] = signal[i, j]
            total = 0.0
            for k in range(len(thresholds)):
                stops[k, j] = min(max(stops[k, j] + step, -thresholds[k]), thresholds[k])
                total += weights[k, j] * stops[k, j]
            out[i, j] = total
    return out


def _way(signal: Array, memory: Memory) -> Array:
    """Path length (n, 3) of a signal (n, 3) on each axis since the start."""
    steps = np.abs(np.diff(signal, axis=0, prepend=memory["left_at"][None]))
    way: Array = memory["way"] + np.cumsum(steps, axis=0)
    memory["left_at"], memory["way"] = signal[-1].copy(), way[-1]
    return way


@kernel
def _rounded(signal: Array, before: Array, loop: Array, threshold: float) -> Array:
    """Rounded loops (n, 3) of a signal (n, 3) from initial values (3,): dD = ds - |ds| D / r, exact for a step."""
    out = np.empty_like(signal)
    for i in range(len(signal)):
        for j in range(3):
            step = signal[i, j] - before[j]
            before[j] = signal[i, j]
            branch = threshold if step > 0 else -threshold
            loop[j] = branch + (loop[j] - branch) * math.exp(-abs(step) / threshold)
            out[i, j] = loop[j]
    return out
