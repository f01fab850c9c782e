"""Small matrices against LAPACK's."""

from __future__ import annotations

import numpy as np
import pytest

from sim.portable_arithmetic import inverse, product, pseudo_inverse


@pytest.mark.parametrize("seed", range(5))
def test_product_inverse_and_pseudo_inverse(seed: int) -> None:
    rng = np.random.default_rng(seed)
    wide = rng.normal(size=(4, 7))
    square = wide @ wide.T
    np.testing.assert_allclose(product(wide, wide.T), square, rtol=1e-14, atol=1e-14)
    np.testing.assert_allclose(inverse(square), np.linalg.inv(square), rtol=1e-11)
    np.testing.assert_allclose(pseudo_inverse(wide), np.linalg.pinv(wide), rtol=1e-11, atol=1e-12)


def test_pseudo_inverse_gives_the_shortest_solution() -> None:
    """Two equal thrusters share a force: x = (F / 2, F / 2)."""
    np.testing.assert_array_equal(pseudo_inverse(np.array([[1.0, 1.0]])), [[0.5], [0.5]])
