"""The compiled unscented filter: the same numbers as filterpy's, over a run."""

from __future__ import annotations

import numpy as np

from calib.methods.ukf import correction
from calib.numerics.unscented import filtered, half_square


def test_half_square_is_the_corrected_fields():
    rng = np.random.default_rng(0)
    state, m = 0.1 * rng.normal(size=9), rng.normal(size=(30, 3))
    h = m @ correction(state) - state[:3]
    np.testing.assert_allclose(half_square(state, m), (h**2).sum(axis=1) / 2, rtol=1e-14)


def test_compiled_filter_is_filterpys():
    rng = np.random.default_rng(1)
    m = rng.normal(size=(40, 12, 3))
    m = m / np.linalg.norm(m, axis=2)[..., None] @ np.diag([1.1, 1.0, 0.95]) + [0.03, -0.02, 0.05]
    blocks = m + 1e-3 * rng.normal(size=m.shape)
    ours, filterpys = (
        filtered(blocks, np.zeros(9), 0.01 * np.eye(9), 3e-3, engine) for engine in ("compiled", "filterpy")
    )
    for one, other in zip(ours, filterpys, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-11)
