"""Sums over a recording by which a nonlinear characteristic of the sensor's axes is looked for, in one pass."""

from __future__ import annotations

import numpy as np

from scenarios.arrays import Array
from scenarios.kernel_cache import njit

COLUMNS = 15
"""Of the offset, of S's upper triangle, and of a quadratic and a cubic term on each axis."""
BLOCK = 64
"""Samples summed together: few enough to stay in the first cache, many enough for the vector units."""


@njit(cache=True)
def _sample(h: Array, A: Array, turn: Array, to_axes: Array, F: float, row: Array) -> float:
    """Fill row (16,) = (X, r) of a corrected field h (3,), and return 1 / |a|^2, a = A^T u of its direction u.

    X = a of b, upper triangle of a k^T + k a^T of S, k = u turn;  a c^2 and a c^3, c = u to_axes;  r = |h| - F
    """
    size = np.sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2])
    u, v, w = h[0] / size, h[1] / size, h[2] / size
    square = 0.0
    for j in range(3):
        a, c = u * A[0, j] + v * A[1, j] + w * A[2, j], u * to_axes[0, j] + v * to_axes[1, j] + w * to_axes[2, j]
        square += a * a
        row[j], row[9 + j], row[12 + j] = a, a * c * c, a * c * c * c
    k0 = u * turn[0, 0] + v * turn[1, 0] + w * turn[2, 0]
    k1 = u * turn[0, 1] + v * turn[1, 1] + w * turn[2, 1]
    k2 = u * turn[0, 2] + v * turn[1, 2] + w * turn[2, 2]
    row[3], row[6], row[8] = row[0] * k0, row[1] * k1, row[2] * k2
    row[4], row[5], row[7] = row[0] * k1 + row[1] * k0, row[0] * k2 + row[2] * k0, row[1] * k2 + row[2] * k1
    row[15] = size - F
    return float(1.0 / square)


@njit(cache=True, fastmath={"reassoc", "contract"})
def _add_products(rows: Array, weight: Array, count: int, out: Array) -> None:
    """out (k, k) += upper triangle of sum over count samples of w x x^T, rows (k, BLOCK)."""
    weighted = np.empty(BLOCK)
    for j in range(len(rows)):
        for i in range(count):
            weighted[i] = weight[i] * rows[j, i]
        for k in range(j, len(rows)):
            total = 0.0
            for i in range(count):
                total += weighted[i] * rows[k, i]
            out[j, k] += total


@njit(cache=True)
def fold_products(field_nT: Array, A: Array, turn: Array, to_axes: Array, F: float, folds: int) -> tuple[Array, Array]:
    """Sum of squares (15,) of the columns X over all samples, and products (folds, 16, 16) of (X, r) / |a| in equal
    blocks of time, which leave out the last samples; see `_sample`. field_nT (n, 3), in order of time.
    """
    n = len(field_nT)
    length, sums, products = n // folds, np.zeros(COLUMNS), np.zeros((folds + 1, COLUMNS + 1, COLUMNS + 1))
    rows, weight, row = np.empty((COLUMNS + 1, BLOCK)), np.empty(BLOCK), np.empty(COLUMNS + 1)
    for fold in range(folds + 1):
        end = (fold + 1) * length if fold < folds else n
        for first in range(fold * length, end, BLOCK):
            count = min(BLOCK, end - first)
            for i in range(count):
                weight[i] = _sample(field_nT[first + i], A, turn, to_axes, F, row)
                for j in range(COLUMNS + 1):
                    rows[j, i] = row[j]
                for j in range(COLUMNS):
                    sums[j] += row[j] * row[j]
            _add_products(rows, weight, count, products[fold])
    for j in range(COLUMNS + 1):
        for k in range(j):
            products[:, j, k] = products[:, k, j]
    return sums, products[:folds]
