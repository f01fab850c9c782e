"""The filter of noise that lasts, against the dense normal density."""

from __future__ import annotations

import numpy as np
import pytest

from calib.numerics.innovations import innovations


def test_a_random_walk_and_a_fading_process_seen_in_turning_directions() -> None:
    """``y = g_i walk + h_i fading + white``, a fifth of the samples unusable: whitened, it is the dense likelihood."""
    rng = np.random.default_rng(3)
    n, white, kept = 80, 0.5, 0.9
    toward, usable = rng.normal(size=(n, 2)), (rng.random(n) > 0.2).astype(float)
    i = np.arange(n)
    processes = np.array([4.0, 2.0]), -np.log([1.0, kept]), np.array([0.3, 0.0])
    walk = 4.0 + 0.3 * np.minimum(i[:, None], i)
    fading = 2.0 * kept ** np.abs(i[:, None] - i)
    C = white * np.eye(n) + np.outer(toward[:, 0], toward[:, 0]) * walk + np.outer(toward[:, 1], toward[:, 1]) * fading
    there = usable > 0
    y, C = rng.normal(size=n), C[np.ix_(there, there)]
    z, ln_S = innovations(y[:, None], toward, processes, i.astype(float), np.full(n, white), usable)
    assert (z**2).sum() == pytest.approx(y[there] @ np.linalg.solve(C, y[there]), rel=1e-10)
    assert ln_S.sum() == pytest.approx(np.linalg.slogdet(C)[1], rel=1e-10)
    assert (z[~there] == 0).all()
