"""Errors of the converter: clipping and rounding."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from scenarios.arrays import Array
from sim.effects.base import Memory, Replacement, frozen
from sim.effects.parameters import Quantity
from sim.effects.traits import Traits
from sim.state import State


@frozen
class Saturation(Replacement):
    """Full scale of the converter: ``clip(s, -S, S)`` on each axis."""

    name = "saturation"
    stage = "electronics"
    example = {"full_scale_nT": 25_000.0}
    traits = Traits(remedy="choose a larger full scale", converter=True, sign="full_scale")

    full_scale_nT: Annotated[float, Quantity("nT", 0.0, 1e9, "S; 0: no limit")] = 0.0

    def replace(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        if self.full_scale_nT == 0:
            return signal_nT
        return np.clip(signal_nT, -self.full_scale_nT, self.full_scale_nT)


@frozen
class Quantisation(Replacement):
    """Least significant bit of the converter: ``q round(s / q)`` on each axis."""

    name = "quantisation"
    stage = "electronics"
    example = {"step_nT": 0.7}
    traits = Traits(remedy="choose a smaller range or a finer converter", converter=True, sign="lattice")

    step_nT: Annotated[float, Quantity("nT", 0.0, 1e5, "q; 0: no rounding")] = 0.0

    def replace(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        if self.step_nT == 0:
            return signal_nT
        rounded: Array = self.step_nT * np.round(signal_nT / self.step_nT)
        return rounded
