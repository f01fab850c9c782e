"""Sums over blocks give the same fit, squares and block means as the whole columns."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.policy import STANDARD
from diagnosis.problem.blocks import Cut, block_sums, extend_sums, fit, held_out_folds, squares, sums


def test_fit_and_squares_equal_dense_least_squares() -> None:
    rng = np.random.default_rng(0)
    n, q, k = 1200, 3, 2
    base, columns, target = rng.normal(size=(n, 4)), rng.normal(size=(n, q, k)), rng.normal(size=(n, q))
    cut = Cut(10, 118, STANDARD.segment_blocks, STANDARD.splits)
    s = sums(cut, base, target, np.ones(n))
    s = extend_sums(s, cut, base, [target[:, :, None]], columns[:, :, :1])
    s = extend_sums(s, cut, base, [target[:, :, None], columns[:, :, :1]], columns[:, :, 1:])
    train = ~list(held_out_folds(STANDARD))[1]
    f = fit(s, train)
    used = np.arange(n) < 1180
    rows = np.concatenate([np.repeat(train[cut.fold], cut.length), np.zeros(20, bool)])
    dense = np.concatenate(
        [np.kron(base[:, None, :], np.eye(q)).reshape(n * q, 4 * q), columns.reshape(n * q, k)], axis=1
    )
    use = np.repeat(rows, q)
    beta = np.linalg.lstsq(dense[use], target.ravel()[use], rcond=None)[0]
    left = target - base @ f.beta - columns @ f.c
    assert f.c == pytest.approx(beta[-k:])
    assert squares(s, f, ~train) == pytest.approx(float((left[~rows & used] ** 2).sum()))
    assert block_sums(s, f) == pytest.approx(left[used].reshape(118, 10, q).sum(axis=1))


def test_outputs_with_a_base_in_common_are_further_rows() -> None:
    rng = np.random.default_rng(1)
    n, q, p, k = 1200, 2, 5, 3
    base, columns, target = rng.normal(size=(n, q, p)), rng.normal(size=(n, q, k)), rng.normal(size=(n, q))
    cut = Cut(10, 120, STANDARD.segment_blocks, STANDARD.splits)
    s = extend_sums(sums(cut, base, target, np.ones(n)), cut, base, [target[:, :, None]], columns)
    train = ~list(held_out_folds(STANDARD))[2]
    f = fit(s, train)
    rows = np.repeat(train[cut.fold], cut.length)
    dense = np.concatenate([base, columns], axis=2)
    beta = np.linalg.lstsq(dense[rows].reshape(-1, p + k), target[rows].ravel(), rcond=None)[0]
    left = target - dense @ beta
    assert np.concatenate([f.beta[:, 0], f.c]) == pytest.approx(beta)
    assert squares(s, f, ~train) == pytest.approx(float((left[~rows] ** 2).sum()))
    assert block_sums(s, f) == pytest.approx(left.reshape(120, 10, q).sum(axis=1))


def test_what_is_held_out_and_trained_on_is_apart_and_goes_round() -> None:
    held = np.array(list(held_out_folds(STANDARD)))
    assert (held.sum(axis=0) == STANDARD.held_segments).all()
