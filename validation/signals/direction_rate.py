"""Rate at which a direction turns."""

from __future__ import annotations

import numpy as np

from scenarios.arrays import Array


def median_rate_rad_s(u: Array, time_s: Array, least_s: float) -> float:
    """Return the median rate of unit vectors u (n, 3) at times (n,), over steps of `least_s` or one sample."""
    step = max(1, round(least_s / float(np.median(np.diff(time_s)))))
    angle = np.arccos(np.clip((u[step:] * u[:-step]).sum(axis=1), -1.0, 1.0))
    return float(np.median(angle / (time_s[step:] - time_s[:-step])))
