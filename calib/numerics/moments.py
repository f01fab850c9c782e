"""Mean and covariance of points, compiled."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


@njit(cache=True, fastmath={"reassoc", "contract"})
def mean_and_spread(x: Array) -> tuple[Array, Array]:
    """Mean (3,) and covariance (3, 3) of points (n, 3), far faster than numpy's sums over short rows."""
    n = len(x)
    a = b = c = 0.0
    for i in range(n):
        a, b, c = a + x[i, 0], b + x[i, 1], c + x[i, 2]
    a, b, c = a / n, b / n, c / n
    aa = ab = ac = bb = bc = cc = 0.0
    for i in range(n):
        u, v, w = x[i, 0] - a, x[i, 1] - b, x[i, 2] - c
        aa, ab, ac, bb, bc, cc = aa + u * u, ab + u * v, ac + u * w, bb + v * v, bc + v * w, cc + w * w
    return np.array([a, b, c]), np.array([[aa, ab, ac], [ab, bb, bc], [ac, bc, cc]]) / (n - 1)
