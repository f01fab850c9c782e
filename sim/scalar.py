"""Scalar magnetometer: the field's strength."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from scenarios.arrays import Array
from sim.chain import Chain
from sim.effects.base import Effect
from sim.state import State

OUTSIDE = ("field", "vehicle")
"""The stages before a sensor, common to vector and scalar magnetometers."""
NUMBER = 9
"""Sensor number in the streams of random numbers, above the numbers of the vector magnetometers."""


class ScalarMagnetometer:
    """Field strength ``|B|``, B with the field of the vehicle, plus the sensor's errors along a single axis.

    Effects of the sensor act on the vector (``|B|``, 0, 0), whose first component is measured: white noise, offset,
    drift and rounding of an axis apply unchanged to a strength.

    Parameters
    ----------
    effects : in the order of the chain; effects of field and vehicle act on B, effects of the sensor on the strength.
    """

    def __init__(self, effects: Sequence[Effect], seed: int, run: int) -> None:
        self._outside = Chain([one for one in effects if one.stage in OUTSIDE], seed, run, NUMBER)
        self._own = Chain([one for one in effects if one.stage not in OUTSIDE], seed, run, NUMBER)

    def measure(self, state: State, finer: State | None = None) -> Array:
        """Measured strength (n,) in nT over the next block; finer: as in `Chain.apply`."""
        along = self._along(finer or state)
        every = 1 if finer is None else round(state.interval_s / finer.interval_s)
        measured_nT, _ = self._own.apply(replace(state, field_nT=along.field_nT[::every]), finer and along)
        return np.ascontiguousarray(measured_nT[:, 0])

    def _along(self, state: State) -> State:
        """The state with the strength outside as field (``|B|``, 0, 0)."""
        field_nT, _ = self._outside.apply(state)
        strength_nT = np.sqrt((field_nT**2).sum(axis=1))
        return replace(state, field_nT=np.column_stack([strength_nT, np.zeros((len(state), 2))]))
