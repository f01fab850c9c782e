"""A sensor whose answer is not a straight line: curvature, and memory of where the signal came from."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from sim.effects.base import ZERO3, Effect, Memory, array, frozen
from sim.effects.clues import AT_SEVERAL_RATES, Clues
from sim.effects.kernels import kernel
from sim.effects.values import Quantity, Vec3
from sim.state import Array, State


@frozen
class Nonlinearity(Effect):
    """Curvature of the characteristic: ``F (c2 (s/F)^2 + c3 (s/F)^3)`` on each axis, F the reference."""

    name = "nonlinearity"
    stage = "sensor"
    static = True
    example = {"second_order": (1e-3, 2e-3, -1e-3), "third_order": (2e-3, 2e-3, 2e-3)}
    clues = Clues(
        apart="turn the sensor about all axes, so that each sees the whole field",
        remedy="measure the characteristic in a coil, or use a sensor with feedback",
    )

    second_order: Annotated[Vec3, Quantity("", -1.0, 1.0, "c2 of the axes x, y, z", role="linear", per_axis=True)] = (
        ZERO3
    )
    third_order: Annotated[Vec3, Quantity("", -1.0, 1.0, "c3 of the axes x, y, z", role="linear", per_axis=True)] = (
        ZERO3
    )
    reference_nT: Annotated[float, Quantity("nT", 1.0, 1e7, "F, at which the error is (c2 + c3) F", role="fixed")] = (
        50_000.0
    )

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        ratio = signal_nT / self.reference_nT
        return signal_nT * ratio * (array(self.second_order) + array(self.third_order) * ratio)

    def conventions(self, state: State, signal_nT: Array) -> Array:
        """Another slope and another value at zero, from which a bend is counted."""
        slopes = signal_nT[:, :, None] * np.eye(3)
        return np.concatenate([slopes, np.tile(self.reference_nT * np.eye(3), (len(state), 1, 1))], axis=2)


@frozen
class Hysteresis(Effect):
    """Lag of the core's magnetisation behind the signal: ``-g E_r(s)``, E_r the stop operator.

    ``e_k = clip(e_k-1 + s_k - s_k-1, -r, r)``, e = 0 at the start, on each axis: what a play of half-width r leaves
    over, never above r. Several thresholds: the mean of their operators, a Prandtl-Ishlinskii model.
    """

    name = "hysteresis"
    stage = "sensor"
    continuous = True
    example = {"gain": (0.02, 0.01, 0.03), "threshold_nT": (200.0, 3000.0)}
    clues = Clues(apart=AT_SEVERAL_RATES, remedy="bias or degauss the core, or use a sensor with feedback")

    gain: Annotated[Vec3, Quantity("", -1.0, 1.0, "g of the axes x, y, z", role="linear", per_axis=True)] = ZERO3
    threshold_nT: Annotated[
        float | tuple[float, ...],
        Quantity(
            "nT",
            1e-3,
            1e6,
            "half-width r of the play, or several",
            role="listed",
            tried=(100.0, 300.0, 1000.0, 3000.0, 10_000.0, 30_000.0, 100_000.0),
        ),
    ] = 1000.0

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        thresholds = np.atleast_1d(array(self.threshold_nT))
        if not memory:
            memory["before"], memory["stops"] = signal_nT[0].copy(), np.zeros((len(thresholds), 3))
        return _stops(signal_nT, memory["before"], memory["stops"], thresholds, -array(self.gain) / len(thresholds))


@kernel
def _stops(signal: Array, before: Array, stops: Array, thresholds: Array, weight: Array) -> Array:
    out = np.empty_like(signal)
    for i in range(len(signal)):
        for j in range(3):
            step = signal[i, j] - before[j]
            before[j] = signal[i, j]
            total = 0.0
            for k in range(len(thresholds)):
                stops[k, j] = min(max(stops[k, j] + step, -thresholds[k]), thresholds[k])
                total += stops[k, j]
            out[i, j] = weight[j] * total
    return out
