"""First-order random processes, drawn block by block."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from scenarios.arrays import Array
from sim.recursion import recursion


@dataclass
class GaussMarkov:
    """Stationary first-order Gauss-Markov process of `width` columns.

    x[k+1] = p x[k] + sqrt(1 - p^2) std w[k],  p = exp(-interval / correlation time),  w ~ N(0, 1).
    """

    std: float
    correlation_s: float
    interval_s: float
    width: int
    rng: np.random.Generator
    _last: Array | None = field(default=None, repr=False)

    def draw(self, n: int) -> Array:
        """The next n samples (n, width), independent of how a run is cut into blocks."""
        p = math.exp(-self.interval_s / self.correlation_s)
        if self._last is None:
            self._last = self.std * self.rng.standard_normal(self.width)
        drive = self.std * math.sqrt(1.0 - p * p) * self.rng.standard_normal((n, self.width))
        out = np.asarray(recursion(drive, p, self._last))
        self._last = out[-1]
        return out
