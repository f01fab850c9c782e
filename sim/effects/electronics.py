"""What the converter does to a value: clip it, round it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sim.effects.base import Memory, Replacement, parameter
from sim.state import Array, State


@dataclass(frozen=True)
class Saturation(Replacement):
    """Full scale of the converter: ``clip(s, -S, S)`` on each axis."""

    name: ClassVar[str] = "saturation"
    stage: ClassVar[str] = "electronics"

    full_scale_nT: float = parameter(0.0, "nT", 0.0, 1e9, "S; 0: no limit")

    def replace(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        if self.full_scale_nT == 0:
            return signal_nT
        return np.clip(signal_nT, -self.full_scale_nT, self.full_scale_nT)


@dataclass(frozen=True)
class Quantisation(Replacement):
    """Least significant bit of the converter: ``q round(s / q)`` on each axis."""

    name: ClassVar[str] = "quantisation"
    stage: ClassVar[str] = "electronics"

    step_nT: float = parameter(0.0, "nT", 0.0, 1e5, "q; 0: no rounding")

    def replace(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        if self.step_nT == 0:
            return signal_nT
        rounded: Array = self.step_nT * np.round(signal_nT / self.step_nT)
        return rounded
