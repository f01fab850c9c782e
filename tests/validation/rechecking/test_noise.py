"""Noise that wanders: likelihood against dense matrices, claimed covariance against the scatter of fits, and tails."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import chi2, ncx2, norm

from scenarios.arrays import Array
from tests.nightly import first_daily
from validation.rechecking.noise import WanderingFit, _restricted
from validation.rechecking.tails import chance_of, reach, size_found

TAU = 25.0


def turn(n: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """Columns (n, 1, 2) of a constant and a turn of 60 samples, and directions (n, 1, 3) of the noise."""
    phase = 2 * np.pi * np.arange(n) / 60 + rng.uniform(0, 6)
    across = np.column_stack([np.cos(phase), np.sin(phase), 0 * phase])
    return np.column_stack([0 * phase + 1.0, np.cos(phase)])[:, None, :], across[:, None, :]


def noise(n: int, a: Array, q: float, rng: np.random.Generator) -> Array:
    """White noise of power 1, and noise of power q that wanders on the three axes, as the rows see both."""
    kicks = np.sqrt(q * (1 - np.exp(-2 / TAU))) * rng.standard_normal((20 * int(TAU) + n, 3))
    slow = lfilter([1.0], [1.0, -np.exp(-1 / TAU)], kicks, axis=0)[-n:]
    return np.einsum("nrk,nk->nr", a, slow) + rng.standard_normal((n, 1))


def test_the_likelihood_is_that_of_dense_matrices() -> None:
    rng, n, q = np.random.default_rng(0), 40, 3.0
    J, a = turn(n, rng)
    r, prior = noise(n, a, q, rng), np.diag([0.1, 0.2])
    lags = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    V = np.eye(n) + q * np.exp(-lags / TAU) * np.einsum("irk,jrk->ij", a, a)
    X, y = J[:, 0], r[:, 0]
    information = X.T @ np.linalg.solve(V, X) + prior
    theta = np.linalg.solve(information, X.T @ np.linalg.solve(V, y))
    left = float(y @ np.linalg.solve(V, y - X @ theta))
    free = n - 2
    expected = -0.5 * (np.linalg.slogdet(V)[1] + np.linalg.slogdet(information)[1] + free * np.log(left))
    rows = np.concatenate([J, r[:, :, None]], axis=2)
    found, white = _restricted(rows, np.ascontiguousarray(a), TAU, q, prior)
    assert found == pytest.approx(expected, abs=1e-8)
    assert white == pytest.approx(left / free)


@pytest.mark.parametrize("q", first_daily([0.0, 2.0]))
def test_one_in_twenty_fits_lies_outside_its_95_percent(q: float) -> None:
    """Of 200 fits to 200 samples between 3 and 22 outside: fewer or more once in 100 runs; 40 outside if white."""
    rng, outside = np.random.default_rng(1), 0
    for _ in range(200):
        J, a = turn(200, rng)
        y = noise(200, a, q, rng)
        theta = np.linalg.lstsq(J[:, 0], y[:, 0], rcond=None)[0]
        fit = WanderingFit(J, y - J @ theta, [a, np.ones((200, 1, 1))])
        spread = fit.covariances(1e-6 * np.eye(2))
        outside += chance_of(theta[1:], spread.covariances[:, 1:, 1:], spread.weights, 1) < 0.05
    assert 3 <= outside <= 22


def test_a_single_model_has_the_tails_of_chi_squared_and_the_normal_distribution() -> None:
    value, spread, one = np.array([1.0, 2.0]), np.array([[[2.0, 0.5], [0.5, 1.0]]]), np.ones(1)
    assert chance_of(value, spread, one, 2) == pytest.approx(chi2.sf(value @ np.linalg.solve(spread[0], value), 2))
    np.testing.assert_allclose(reach(0.01, np.array([[3.0]]), one), 3.0 * norm.isf(0.01))
    size = size_found(np.array([4.0]), one, 0.002, 0.95, 3)
    assert ncx2.sf(chi2.isf(0.002, 3), 3, size**2 / 4.0) == pytest.approx(0.95)


def test_several_models_are_averaged() -> None:
    weights, stds = np.array([0.7, 0.3]), np.array([[1.0], [5.0]])
    (wide,) = reach(0.02, stds, weights)
    assert weights @ norm.sf(wide / stds[:, 0]) == pytest.approx(0.02)
    chance = chance_of(np.array([4.0]), stds[:, :, None] ** 2, weights, 1)
    assert chance == pytest.approx(weights @ chi2.sf((4.0 / stds[:, 0]) ** 2, 1))
