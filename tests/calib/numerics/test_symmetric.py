"""The inverse of a symmetric matrix that may be singular is numpy's pseudo-inverse."""

from __future__ import annotations

import numpy as np
import pytest

from calib.numerics.symmetric import symmetric_inverse


@pytest.mark.parametrize("rank", range(5))
def test_it_is_the_pseudo_inverse_of_a_matrix_of_any_rank_and_sign(rank: int) -> None:
    rng = np.random.default_rng(rank)
    axes = np.linalg.qr(rng.normal(size=(3, 4, 4)))[0]
    w = np.where(np.arange(4) < rank, rng.choice([-1.0, 1.0], 4) * rng.uniform(1, 1e4, 4), 1e-12)
    M = (axes * w) @ axes.swapaxes(1, 2)
    M = (M + M.swapaxes(1, 2)) / 2
    if not rank:
        M *= 0
    np.testing.assert_allclose(symmetric_inverse(M, 1e-9), np.linalg.pinv(M, rcond=1e-9, hermitian=True), atol=1e-12)


def test_a_direction_counts_from_the_stated_share_of_the_largest() -> None:
    np.testing.assert_allclose(symmetric_inverse(np.diag([4.0, 1e-3, -1e-5]), 1e-4), np.diag([0.25, 1e3, 0.0]))


def test_no_columns_have_no_inverse() -> None:
    assert symmetric_inverse(np.zeros((0, 0)), 1e-9).shape == (0, 0)
