"""Series whose noise, converter and faults are known."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
RATE_HZ = 50.0
FIELD_NT = 50_000.0


def turning(samples: int, rate_rad_s: float = 0.4) -> tuple[Array, Array]:
    """Times (n,) and the field (n, 3) in a body that turns about all its axes, at varying rate."""
    time_s = np.arange(samples) / RATE_HZ
    yaw = np.cumsum(rate_rad_s * (1 + 0.5 * np.sin(0.1 * time_s))) / RATE_HZ
    pitch, roll = 0.9 * np.sin(0.23 * time_s), 0.9 * np.sin(0.17 * time_s)
    level = np.cos(yaw) * np.cos(pitch)
    rest = np.sqrt(1 - level**2)
    angle = roll + yaw
    return time_s, FIELD_NT * np.column_stack([level, rest * np.cos(angle), rest * np.sin(angle)])


def still(samples: int) -> tuple[Array, Array]:
    """Times (n,) and a constant field (n, 3)."""
    return np.arange(samples) / RATE_HZ, np.tile([20_013.7, -11_201.2, 38_007.9], (samples, 1))


def rounded(values: Array, step: float) -> Array:
    """Values on a converter's steps; as they are for a step of zero."""
    return step * np.round(values / step) if step else values
