"""States carried by a gyro, eliminated one after the other, against the whole least squares at once."""

from __future__ import annotations

import numpy as np
import pytest

from calib.numerics.chain import chained, eliminated, states


def whole(M, J, turn, B, std):
    """All rows of the least squares, states first."""
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
    return np.concatenate(rows)


def dense(rows, n):
    """The information of the parameters: a Schur complement of one large matrix."""
    states_of, rest = np.linalg.qr(rows[:, : 2 * n])[0], rows[:, 2 * n :]
    left = rest - states_of @ (states_of.T @ rest)
    return left.T @ left


def example(std):
    rng = np.random.default_rng(0)
    M, J = rng.normal(size=(40, 3, 2)), rng.normal(size=(40, 3, 5))
    return M, J, rng.normal(size=(39, 2, 2)), rng.normal(size=(39, 2, 5)), std * np.ones(39)


@pytest.mark.parametrize("std", [1e-3, 1.0, 1e3])
def test_elimination_equals_the_dense_matrix(std):
    chain = example(std)
    expected = dense(whole(*chain), 40)
    np.testing.assert_allclose(chained(*chain), expected, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("std", [0.1, 1.0])
def test_determinant_is_that_of_the_states_information(std):
    chain = example(std)
    rows = whole(*chain)[:, :80]
    assert eliminated(*chain)[1] == pytest.approx(np.linalg.slogdet(rows.T @ rows)[1], rel=1e-10)


@pytest.mark.parametrize("std", [1e-3, 1.0, 1e3])
def test_states_are_those_of_the_dense_least_squares(std):
    chain = example(std)
    turn, B, deviation = chain[2:]
    p = np.random.default_rng(1).normal(size=5)
    rows = whole(*chain)
    expected = np.linalg.lstsq(rows[:, :80], -rows[:, 80:] @ p, rcond=None)[0]
    A, C = eliminated(*chain)[2:]
    found = states(A, C, turn, B, deviation, p)
    np.testing.assert_allclose(found.ravel(), expected, rtol=1e-6, atol=1e-6)
