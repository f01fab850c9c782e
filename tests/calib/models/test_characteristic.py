"""Sums of a characteristic's columns, in one pass, against products of the columns by numpy."""

from __future__ import annotations

import numpy as np

from calib.models.characteristic import fold_products

F, FOLDS = 5.0, 4


def test_sums_are_products_of_the_columns() -> None:
    """Columns by the derivative of |A (m - b)|, S's six by their two entries; folds leave out three samples."""
    rng = np.random.default_rng(0)
    h = rng.normal(0.0, F, (363, 3))
    A, to_axes = np.eye(3) + 0.1 * rng.normal(size=(2, 3, 3))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    length = np.linalg.norm(h, axis=1)
    u = h / length[:, None]
    a, k, c = u @ A, u @ turn, u @ to_axes
    pairs = [a[:, i] * k[:, j] + (a[:, j] * k[:, i] if i != j else 0.0) for i in range(3) for j in range(i, 3)]
    X = np.column_stack((a, *pairs, a * c**2, a * c**3, length - F))
    sums, products = fold_products(h, A, turn, to_axes, F, FOLDS)
    np.testing.assert_allclose(sums, (X[:, :-1] ** 2).sum(axis=0), rtol=1e-12)
    scaled = X / np.linalg.norm(a, axis=1)[:, None]
    for part, found in zip(np.split(scaled[:360], FOLDS), products, strict=True):
        np.testing.assert_allclose(found, part.T @ part, rtol=1e-10, atol=1e-10)
