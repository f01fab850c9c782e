"""A magnetometer of the field's strength, beside those of three axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from scenarios.arrays import Array
from sim.chain import Chain
from sim.effects.base import Effect
from sim.state import State

OUTSIDE = ("field", "vehicle")
"""The stages that act before a sensor: what a magnetometer of the strength sees too."""
NUMBER = 9
"""Its number in the streams of random numbers, above those of the magnetometers of three axes."""


class ScalarMagnetometer:
    """Field strength ``|B|`` at its place, B with the field of the vehicle, then its own errors along one axis.

    Its own effects act on the vector (``|B|``, 0, 0), of which the first component is measured: white noise, offset,
    drift and rounding of an axis serve a strength as they are.

    Parameters
    ----------
    effects : in the chain's order; those of the field and the vehicle act on B, the others on its strength.
    """

    def __init__(self, effects: Sequence[Effect], seed: int, run: int) -> None:
        self._outside = Chain([one for one in effects if one.stage in OUTSIDE], seed, run, NUMBER)
        self._own = Chain([one for one in effects if one.stage not in OUTSIDE], seed, run, NUMBER)

    def measure(self, state: State, finer: State | None = None) -> Array:
        """Measured strength (n,) in nT over the run's next block; finer: as `Chain.apply` takes it."""
        along = self._along(finer or state)
        every = 1 if finer is None else round(state.interval_s / finer.interval_s)
        measured_nT, _ = self._own.apply(replace(state, field_nT=along.field_nT[::every]), finer and along)
        return np.ascontiguousarray(measured_nT[:, 0])

    def _along(self, state: State) -> State:
        """The state with the strength outside as its field (``|B|``, 0, 0)."""
        field_nT, _ = self._outside.apply(state)
        strength_nT = np.sqrt((field_nT**2).sum(axis=1))
        return replace(state, field_nT=np.column_stack([strength_nT, np.zeros((len(state), 2))]))
