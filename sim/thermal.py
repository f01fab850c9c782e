"""Temperature of the magnetometer: first-order lag behind the surroundings and the motors' heat."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from scenarios.arrays import Array
from scenarios.spec import ThermalSpec
from sim.portable_arithmetic import extended
from sim.recursion import recursion


@dataclass
class Thermometer:
    """tau dT/dt = T_env(z) + heating_K_W P - T, stepped exactly for an input held over a sample interval.

    T_env = deep + (surface - deep) exp(z / scale) below the surface; P = resistance x sum of squared currents.
    """

    spec: ThermalSpec
    interval_s: float
    resistance_ohm: float = 0.1
    _last: float | None = field(default=None, repr=False)

    def temperature_degC(self, depth_m: Array, current_A: Array) -> Array:
        """Temperature (n,) at the next n samples, from depth (n,) and motor currents (n, m)."""
        s = self.spec
        decay = np.exp(extended(-np.maximum(depth_m, 0.0) / s.scale_depth_m)).astype(np.float64)
        around = s.deep_degC + (s.surface_degC - s.deep_degC) * decay
        goal = around + s.heating_K_W * self.resistance_ohm * (current_A**2).sum(axis=1)
        if self._last is None:
            self._last = float(around[0]) if s.initial_degC is None else s.initial_degC
        p = math.exp(-self.interval_s / s.time_constant_s)
        out = recursion((1.0 - p) * goal[:, None], p, np.array([self._last]))[:, 0]
        self._last = float(out[-1])
        return np.asarray(out)
