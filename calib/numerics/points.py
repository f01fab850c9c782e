"""Sums and maps of points (n, 3), compiled: numpy is slow over rows as short as three."""

from __future__ import annotations

import numpy as np

from scenarios.arrays import Array
from scenarios.kernel_cache import njit


@njit(cache=True, fastmath={"reassoc", "contract"})
def mean_and_spread(x: Array) -> tuple[Array, Array]:
    """Mean (3,) and covariance (3, 3) of points (n, 3)."""
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


@njit(cache=True)
def scaled(x: Array, middle: Array, scale: float) -> Array:
    """(x - middle) / scale (n, 3)."""
    out = np.empty((len(x), 3))
    for i in range(len(x)):
        for j in range(3):
            out[i, j] = (x[i, j] - middle[j]) / scale
    return out


@njit(cache=True)
def mapped(x: Array, offset: Array, matrix: Array) -> Array:
    """Rows matrix (x - offset) (n, 3)."""
    out = np.empty((len(x), 3))
    for i in range(len(x)):
        u, v, w = x[i, 0] - offset[0], x[i, 1] - offset[1], x[i, 2] - offset[2]
        for j in range(3):
            out[i, j] = matrix[j, 0] * u + matrix[j, 1] * v + matrix[j, 2] * w
    return out


@njit(cache=True)
def lengths(x: Array) -> Array:
    """|x| (n,)."""
    out = np.empty(len(x))
    for i in range(len(x)):
        out[i] = np.sqrt(x[i, 0] * x[i, 0] + x[i, 1] * x[i, 1] + x[i, 2] * x[i, 2])
    return out


@njit(cache=True)
def ranges(x: Array) -> tuple[Array, Array]:
    """Least and greatest value (3,) of each component of points (n, 3)."""
    low, high = x[0].copy(), x[0].copy()
    for i in range(1, len(x)):
        for j in range(3):
            low[j], high[j] = min(low[j], x[i, j]), max(high[j], x[i, j])
    return low, high


@njit(cache=True)
def strengths(x: Array, offset: Array, matrix: Array) -> Array:
    """|matrix (x - offset)| (n,) of points (n, 3)."""
    out = np.empty(len(x))
    for i in range(len(x)):
        u, v, w = x[i, 0] - offset[0], x[i, 1] - offset[1], x[i, 2] - offset[2]
        square = 0.0
        for j in range(3):
            h = matrix[j, 0] * u + matrix[j, 1] * v + matrix[j, 2] * w
            square += h * h
        out[i] = np.sqrt(square)
    return out


@njit(cache=True)
def lengths_and_slopes(h: Array, matrix: Array) -> tuple[Array, Array]:
    """|h| (n,) and (h / |h|)^T matrix (n, 3) of vectors h (n, 3)."""
    size, slope = np.empty(len(h)), np.empty((len(h), 3))
    for i in range(len(h)):
        size[i] = np.sqrt(h[i, 0] * h[i, 0] + h[i, 1] * h[i, 1] + h[i, 2] * h[i, 2])
        u, v, w = h[i, 0] / size[i], h[i, 1] / size[i], h[i, 2] / size[i]
        for j in range(3):
            slope[i, j] = u * matrix[0, j] + v * matrix[1, j] + w * matrix[2, j]
    return size, slope


@njit(cache=True)
def turning_field(centred: Array, S: Array, B: Array, rate: Array) -> Array:
    """h (n, 3) of (S - B [w]x) h = m - b, for m - b centred (n, 3) and w rate (n, 3); by Cramer's rule.

    ZeroDivisionError where a system is singular.
    """
    out, M = np.empty((len(centred), 3)), np.empty((3, 3))
    for n in range(len(centred)):
        u, v, w = rate[n]
        for i in range(3):
            M[i, 0] = S[i, 0] - B[i, 1] * w + B[i, 2] * v
            M[i, 1] = S[i, 1] + B[i, 0] * w - B[i, 2] * u
            M[i, 2] = S[i, 2] - B[i, 0] * v + B[i, 1] * u
        whole = 0.0
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            whole += M[0, k] * (M[1, i] * M[2, j] - M[1, j] * M[2, i])
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            part = centred[n, 0] * (M[1, i] * M[2, j] - M[1, j] * M[2, i])
            part += centred[n, 1] * (M[2, i] * M[0, j] - M[2, j] * M[0, i])
            out[n, k] = (part + centred[n, 2] * (M[0, i] * M[1, j] - M[0, j] * M[1, i])) / whole
    return out


def cross_matrices(v: Array) -> Array:
    """[v]x (n, 3, 3), so that [v]x a = v x a."""
    out = np.zeros((len(v), 3, 3))
    out[:, 0, 1], out[:, 0, 2], out[:, 1, 2] = -v[:, 2], v[:, 1], -v[:, 0]
    return out - out.transpose(0, 2, 1)
