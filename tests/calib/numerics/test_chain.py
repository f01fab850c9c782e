"""States carried by a gyro, eliminated one after the other, against the whole information matrix at once."""

from __future__ import annotations

import numpy as np

from calib.numerics.chain import chained


def dense(M, J, turn, B, std):
    """The information of the parameters from all states together: a Schur complement of one large matrix."""
    n, k = len(M), J.shape[2]
    rows = []
    for i in range(n):
        row = np.zeros((3, 2 * n + k))
        row[:, 2 * i : 2 * i + 2], row[:, 2 * n :] = M[i], J[i]
        rows.append(row)
    for i in range(n - 1):
        row = np.zeros((2, 2 * n + k))
        row[:, 2 * i : 2 * i + 2], row[:, 2 * i + 2 : 2 * i + 4], row[:, 2 * n :] = -turn[i], np.eye(2), -B[i]
        rows.append(row / std[i])
    whole = np.concatenate(rows)
    states, rest = np.linalg.qr(whole[:, : 2 * n])[0], whole[:, 2 * n :]
    left = rest - states @ (states.T @ rest)
    return left.T @ left


def test_elimination_equals_the_dense_matrix():
    rng = np.random.default_rng(0)
    for std in (1e-3, 1.0, 1e3):
        M, J = rng.normal(size=(40, 3, 2)), rng.normal(size=(40, 3, 5))
        turn, B = rng.normal(size=(39, 2, 2)), rng.normal(size=(39, 2, 5))
        expected = dense(M, J, turn, B, std * np.ones(39))
        np.testing.assert_allclose(chained(M, J, turn, B, std * np.ones(39)), expected, rtol=1e-8, atol=1e-8)
