"""Elimination of a direction that the gyro carries from sample to sample, exact and linear in the samples.

sum_i |M_i x_i + J_i p|^2 + sum_i |x_(i+1) - turn_i x_i - B_i p|^2 / std_i^2

States x_i (2,), parameters p (k,). M : (n, 3, 2), J : (n, 3, k), both in units of the noise; turn : (n - 1, 2, 2),
B : (n - 1, 2, k), std : (n - 1,).
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


def chained(M: Array, J: Array, turn: Array, B: Array, std: Array) -> Array:
    """Information (k, k) of the parameters when the states between them are not known."""
    information: Array = eliminated(M, J, turn, B, std)[0]
    return information


@njit(cache=True)
def eliminated(M: Array, J: Array, turn: Array, B: Array, std: Array) -> tuple[Array, float, Array, Array]:
    """Information (k, k) of the parameters; log det of the states' own; A (n, 2, 2) and C (n, 2, k) along the way.

    The states go one after the other: A, C, D are what all up to a sample says of (x_i, p),
    x^T A x + 2 x^T C p + p^T D p, the Schur complement over the states before.
    """
    n, k = len(M), J.shape[2]
    As, Cs, D = np.empty((n, 2, 2)), np.empty((n, 2, k)), np.zeros((k, k))
    A, C = np.zeros((2, 2)), np.zeros((2, k))
    logarithm = 0.0
    for i in range(n):
        if i > 0:
            logarithm += _carried(A, C, D, turn[i - 1], B[i - 1], std[i - 1] ** 2)
        _seen(A, C, D, M[i], J[i])
        As[i], Cs[i] = A, C
    P = _inverse(A)
    _taken(D, P, C)
    for a in range(k):
        for b in range(a):
            D[a, b] = D[b, a]
    return D, logarithm - np.log(P[0, 0] * P[1, 1] - P[0, 1] * P[1, 0]), As, Cs


@njit(cache=True)
def states(A: Array, C: Array, turn: Array, B: Array, std: Array, p: Array) -> Array:
    """The best states (n, 2) for parameters p (k,), from what `eliminated` found along the way, last to first.

    (A + turn^T turn / std^2) x = turn^T (x_next - B p) / std^2 - C p
    """
    n, k = len(A), len(p)
    out, drawn, pull = np.empty((n, 2)), np.empty(2), np.empty(2)
    for i in range(n - 1, -1, -1):
        square = A[i].copy()
        for a in range(2):
            pull[a] = 0.0
            for j in range(k):
                pull[a] -= C[i, a, j] * p[j]
        if i < n - 1:
            weight = 1.0 / std[i] ** 2
            for a in range(2):
                drawn[a] = out[i + 1, a]
                for j in range(k):
                    drawn[a] -= B[i, a, j] * p[j]
            for a in range(2):
                for b in range(2):
                    pull[a] += weight * turn[i, b, a] * drawn[b]
                    square[a, b] += weight * (turn[i, 0, a] * turn[i, 0, b] + turn[i, 1, a] * turn[i, 1, b])
        P = _inverse(square)
        for a in range(2):
            out[i, a] = P[a, 0] * pull[0] + P[a, 1] * pull[1]
    return out


@njit(cache=True)
def _carried(A: Array, C: Array, D: Array, turn: Array, B: Array, variance: float) -> float:
    """A, C, D of a sample to those of the next, in place; gives log det (A + turn^T turn / variance).

    A' = (turn A^-1 turn^T + variance)^-1,  C' = A' (turn A^-1 C - B),  D' = D - C^T A^-1 C + C'^T A'^-1 C'
    """
    P = _inverse(A)
    _taken(D, P, C)
    moved = turn @ P
    spread = moved @ turn.T
    spread[0, 0] += variance
    spread[1, 1] += variance
    drawn = moved @ C - B
    A[:] = _inverse(spread)
    C[:] = A @ drawn
    for a in range(2):
        for i in range(C.shape[1]):
            for j in range(i, C.shape[1]):
                D[i, j] += drawn[a, i] * C[a, j]
    over = (spread[0, 0] * spread[1, 1] - spread[0, 1] * spread[1, 0]) / variance**2
    return float(np.log(over / (P[0, 0] * P[1, 1] - P[0, 1] * P[1, 0])))


@njit(cache=True)
def _seen(A: Array, C: Array, D: Array, M: Array, J: Array) -> None:
    """Add |M x + J p|^2 to A, C and the upper triangle of D."""
    k = J.shape[1]
    for row in range(3):
        for a in range(2):
            for b in range(2):
                A[a, b] += M[row, a] * M[row, b]
            for j in range(k):
                C[a, j] += M[row, a] * J[row, j]
        for i in range(k):
            part = J[row, i]
            if part != 0.0:
                for j in range(i, k):
                    D[i, j] += part * J[row, j]


@njit(cache=True)
def _taken(D: Array, P: Array, C: Array) -> None:
    """Take C^T P C off the upper triangle of D."""
    for i in range(C.shape[1]):
        a = P[0, 0] * C[0, i] + P[0, 1] * C[1, i]
        b = P[1, 0] * C[0, i] + P[1, 1] * C[1, i]
        for j in range(i, C.shape[1]):
            D[i, j] -= a * C[0, j] + b * C[1, j]


@njit(cache=True)
def _inverse(A: Array) -> Array:
    """Of a (2, 2)."""
    determinant = A[0, 0] * A[1, 1] - A[0, 1] * A[1, 0]
    inverse: Array = np.array([[A[1, 1], -A[0, 1]], [-A[1, 0], A[0, 0]]]) / determinant
    return inverse
