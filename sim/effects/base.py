"""An effect: one frozen dataclass that the simulator injects, the dataset labels and the diagnosis proposes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from sim.state import Array, State

Vec3 = tuple[float, float, float]
Mat3 = tuple[Vec3, Vec3, Vec3]
ZERO3: Vec3 = (0.0, 0.0, 0.0)
ZERO33: Mat3 = (ZERO3, ZERO3, ZERO3)


def parameter(default: Any, unit: str, low: float, high: float, doc: str) -> Any:
    """A dataclass field with what users and the diagnosis need: unit, the bounds of each component, meaning."""
    return field(default=default, metadata={"unit": unit, "low": low, "high": high, "doc": doc})


@dataclass(frozen=True)
class Effect(ABC):
    """One disturbance: a frozen dataclass of physical parameters (unit in the name), each made by `parameter`.

    ``signal_out = signal_in + apply(state, signal_in, rng, memory)``: what it returns is also its label.

    Class attributes: `name` (fixed by DESIGN), `stage` ("field", "vehicle", "sensor", "electronics"), `needs` (columns of State
    that must be measured for the diagnosis to propose it: "attitude", "rate", "position", "current", "temperature"),
    `linear` (the parameters in which the contribution is linear, zero when they are zero: they give `basis` for free),
    `stochastic` (draws from rng).
    """

    name: ClassVar[str]
    stage: ClassVar[str]
    needs: ClassVar[tuple[str, ...]] = ()
    linear: ClassVar[tuple[str, ...]] = ()
    stochastic: ClassVar[bool] = False

    @abstractmethod
    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: dict[str, Any]) -> Array:
        """Contribution (n, 3) in nT to a block of the signal (n, 3), body (sensor) frame.

        `memory` is empty at the start of a run and handed on from block to block: filter states, last samples,
        sub-streams of rng. Cutting a run into other blocks gives the same contribution.
        """
