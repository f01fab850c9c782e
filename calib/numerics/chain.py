"""Elimination of a direction that the gyro carries from sample to sample, exact and linear in the samples."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


@njit(cache=True)
def chained(M: Array, J: Array, turn: Array, B: Array, std: Array) -> Array:
    """Information (k, k) of the parameters p when the states x_i (2,) between them are not known.

    sum_i |M_i x_i + J_i p|^2 + sum_i |x_(i+1) - turn_i x_i - B_i p|^2 / std_i^2

    M : (n, 3, 2), J : (n, 3, k), both in units of the noise; turn : (n - 1, 2, 2), B : (n - 1, 2, k), std : (n - 1,).
    The states go one after the other: A, C, D are what all before says of (x_i, p), the Schur complement over them.
    """
    A, C, D = M[0].T @ M[0], M[0].T @ J[0], J[0].T @ J[0]
    for i in range(1, len(M)):
        P = np.linalg.inv(A)
        D = D - C.T @ P @ C
        moved = turn[i - 1] @ P
        A = np.linalg.inv(moved @ turn[i - 1].T + std[i - 1] ** 2 * np.eye(2))
        drawn = moved @ C - B[i - 1]
        C = A @ drawn
        D = D + drawn.T @ C
        A, C, D = A + M[i].T @ M[i], C + M[i].T @ J[i], D + J[i].T @ J[i]
    left: Array = D - C.T @ np.linalg.inv(A) @ C
    return left
