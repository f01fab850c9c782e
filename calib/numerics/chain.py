"""Elimination of a direction or attitude that the gyro carries from sample to sample, exact and linear in the samples.

sum_i |M_i x_i + J_i p|^2 + sum_i |x_(i+1) - turn_i x_i - B_i p|^2 / std_i^2

States x_i (m,), two coordinates of a direction or three of an attitude; parameters p (k,). M : (n, r, m) and
J : (n, r, k), both in units of the noise; turn : (n - 1, m, m), B : (n - 1, m, k), std : (n - 1,).
"""

from __future__ import annotations

import numpy as np

from scenarios.arrays import Array
from scenarios.kernel_cache import njit


def chained(M: Array, J: Array, turn: Array, B: Array, std: Array) -> Array:
    """Information (k, k) of the parameters when the states between them are not known."""
    information: Array = eliminated(M, J, turn, B, std)[0]
    return information


@njit(cache=True)
def eliminated(M: Array, J: Array, turn: Array, B: Array, std: Array) -> tuple[Array, float, Array, Array]:
    """Information (k, k) of the parameters; log det of the states' own; A (n, m, m) and C (n, m, k) along the way.

    The states go one after the other: A, C, D are what all up to a sample says of (x_i, p),
    x^T A x + 2 x^T C p + p^T D p, the Schur complement over the states before.
    """
    n, m, k = len(M), M.shape[2], J.shape[2]
    As, Cs, D = np.empty((n, m, m)), np.empty((n, m, k)), np.zeros((k, k))
    A, C = np.zeros((m, m)), np.zeros((m, k))
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
    return D, logarithm - np.log(_determinant(P)), As, Cs


@njit(cache=True)
def states(A: Array, C: Array, turn: Array, B: Array, std: Array, p: Array) -> Array:
    """The best states (n, m) for parameters p (k,), from what `eliminated` found along the way, last to first.

    (A + turn^T turn / std^2) x = turn^T (x_next - B p) / std^2 - C p
    """
    n, m, k = len(A), A.shape[1], len(p)
    out, drawn, pull = np.empty((n, m)), np.empty(m), np.empty(m)
    for i in range(n - 1, -1, -1):
        square = A[i].copy()
        for a in range(m):
            pull[a] = 0.0
            for j in range(k):
                pull[a] -= C[i, a, j] * p[j]
        if i < n - 1:
            weight = 1.0 / std[i] ** 2
            for a in range(m):
                drawn[a] = out[i + 1, a]
                for j in range(k):
                    drawn[a] -= B[i, a, j] * p[j]
            for a in range(m):
                for c in range(m):
                    pull[a] += weight * turn[i, c, a] * drawn[c]
                    for b in range(m):
                        square[a, b] += weight * turn[i, c, a] * turn[i, c, b]
        P = _inverse(square)
        for a in range(m):
            out[i, a] = 0.0
            for b in range(m):
                out[i, a] += P[a, b] * pull[b]
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
    m = len(A)
    for a in range(m):
        spread[a, a] += variance
    drawn = moved @ C - B
    A[:] = _inverse(spread)
    C[:] = A @ drawn
    for a in range(m):
        for i in range(C.shape[1]):
            for j in range(i, C.shape[1]):
                D[i, j] += drawn[a, i] * C[a, j]
    return float(np.log(_determinant(spread) / variance**m / _determinant(P)))


@njit(cache=True)
def _seen(A: Array, C: Array, D: Array, M: Array, J: Array) -> None:
    """Add |M x + J p|^2 to A, C and the upper triangle of D."""
    r, m, k = M.shape[0], M.shape[1], J.shape[1]
    for row in range(r):
        for a in range(m):
            for b in range(m):
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
    drawn = P @ C
    for a in range(len(P)):
        for i in range(C.shape[1]):
            for j in range(i, C.shape[1]):
                D[i, j] -= drawn[a, i] * C[a, j]


@njit(cache=True)
def _determinant(A: Array) -> float:
    """Of a (2, 2) or (3, 3)."""
    if len(A) == 2:
        return float(A[0, 0] * A[1, 1] - A[0, 1] * A[1, 0])
    return float(
        A[0, 0] * (A[1, 1] * A[2, 2] - A[1, 2] * A[2, 1])
        - A[0, 1] * (A[1, 0] * A[2, 2] - A[1, 2] * A[2, 0])
        + A[0, 2] * (A[1, 0] * A[2, 1] - A[1, 1] * A[2, 0])
    )


@njit(cache=True)
def _inverse(A: Array) -> Array:
    """Of a (2, 2) or (3, 3), by its cofactors."""
    out = np.empty_like(A)
    if len(A) == 2:
        out[0, 0], out[0, 1], out[1, 0], out[1, 1] = A[1, 1], -A[0, 1], -A[1, 0], A[0, 0]
    else:
        for i in range(3):
            for j in range(3):
                a, b, c, d = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
                out[j, i] = A[a, c] * A[b, d] - A[a, d] * A[b, c]
    inverse: Array = out / _determinant(A)
    return inverse
