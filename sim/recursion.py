"""First-order recursion, compiled: scipy's filter takes half a second of imports."""

from __future__ import annotations

import numpy as np

from scenarios.arrays import Array
from scenarios.kernel_cache import njit


@njit(cache=True, nogil=True)
def recursion(drive: Array, decay: float, before: Array) -> Array:
    """Return x (n, k) with x[i] = decay x[i-1] + drive[i]; before (k,) is x[-1]."""
    out = np.empty_like(drive)
    for i in range(len(drive)):
        for j in range(drive.shape[1]):
            out[i, j] = decay * (before[j] if i == 0 else out[i - 1, j]) + drive[i, j]
    return out
