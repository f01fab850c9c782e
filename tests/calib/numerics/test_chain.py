"""States carried by a gyro, eliminated one after the other, against the whole least squares at once."""

from __future__ import annotations

import numpy as np
import pytest

from calib.numerics.chain import chained, eliminated, states


def whole(M, J, turn, B, std):
    """All rows of the least squares, states first."""
    (n, r, m), k = M.shape, J.shape[2]
    rows = []
    for i in range(n):
        row = np.zeros((r, m * n + k))
        row[:, m * i : m * i + m], row[:, m * n :] = M[i], J[i]
        rows.append(row)
    for i in range(n - 1):
        row = np.zeros((m, m * n + k))
        row[:, m * i : m * i + m], row[:, m * i + m : m * i + 2 * m], row[:, m * n :] = -turn[i], np.eye(m), -B[i]
        rows.append(row / std[i])
    return np.concatenate(rows)


def dense(rows, states):
    """The information of the parameters: a Schur complement of one large matrix."""
    states_of, rest = np.linalg.qr(rows[:, :states])[0], rows[:, states:]
    left = rest - states_of @ (states_of.T @ rest)
    return left.T @ left


def example(std, size):
    """A direction of which three rows are seen, or an attitude of which six are."""
    rng, m = np.random.default_rng(0), size
    M, J = rng.normal(size=(40, 3 * m - 3, m)), rng.normal(size=(40, 3 * m - 3, 5))
    return M, J, np.linalg.qr(rng.normal(size=(39, m, m)))[0], rng.normal(size=(39, m, 5)), std * np.ones(39)


SIZES = pytest.mark.parametrize("size", [2, 3])


@SIZES
@pytest.mark.parametrize("std", [1e-3, 1.0, 1e3])
def test_elimination_equals_the_dense_matrix(std, size):
    chain = example(std, size)
    expected = dense(whole(*chain), 40 * size)
    np.testing.assert_allclose(chained(*chain), expected, rtol=1e-8, atol=1e-8)


@SIZES
@pytest.mark.parametrize("std", [0.1, 1.0])
def test_determinant_is_that_of_the_states_information(std, size):
    chain = example(std, size)
    rows = whole(*chain)[:, : 40 * size]
    assert eliminated(*chain)[1] == pytest.approx(np.linalg.slogdet(rows.T @ rows)[1], rel=1e-10)


@SIZES
@pytest.mark.parametrize("std", [1e-3, 1.0, 1e3])
def test_states_are_those_of_the_dense_least_squares(std, size):
    chain = example(std, size)
    turn, B, deviation = chain[2:]
    p = np.random.default_rng(1).normal(size=5)
    rows = whole(*chain)
    expected = np.linalg.lstsq(rows[:, : 40 * size], -rows[:, 40 * size :] @ p, rcond=None)[0]
    A, C = eliminated(*chain)[2:]
    found = states(A, C, turn, B, deviation, p)
    np.testing.assert_allclose(found.ravel(), expected, rtol=1e-6, atol=1e-6)
