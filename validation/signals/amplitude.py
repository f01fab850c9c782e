"""Root mean squares."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from scenarios.arrays import Array


def rms(values: ArrayLike) -> float:
    """Return the root mean square of all elements."""
    return float(np.sqrt(np.mean(np.square(values))))


def column_rms(values: Array) -> Array:
    """Return the root mean square (k,) of each column of values (n, k)."""
    return np.asarray(np.sqrt(np.mean(np.square(values), axis=0)))
