"""The search on normal equations ends where a dense least squares does, also in a bent valley."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from calib.numerics.squares import Squares
from scenarios.arrays import Array


def test_a_bent_valley_is_followed_to_its_end() -> None:
    def rosenbrock(x: Array) -> Array:
        return np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]])

    assert Squares(rosenbrock).least(np.array([-1.2, 1.0]), 60) == pytest.approx([1.0, 1.0], abs=1e-3)


def test_of_noisy_data_it_is_the_dense_solution() -> None:
    rng = np.random.default_rng(0)
    t = np.linspace(0, 10, 400)

    def residual(x: Array) -> Array:
        return np.asarray((1 + x[0]) * np.exp(-t / np.exp(x[1])) + x[2] * np.cos(t) - y)

    y = np.zeros(400)
    y = residual(np.array([1.0, 0.7, -0.5])) + 0.1 * rng.normal(size=400)
    dense = least_squares(residual, np.zeros(3), xtol=1e-12, ftol=1e-12)
    squares = Squares(residual)
    best = squares.least(np.zeros(3), 60)
    gram = dense.jac.T @ dense.jac
    assert np.abs((best - dense.x) / np.sqrt(np.diag(np.linalg.inv(gram)))).max() < 0.1
    assert squares.gram(best) == pytest.approx(gram, rel=0.02)
    assert squares.gradient(best) == pytest.approx(np.zeros(3), abs=0.01 * np.sqrt(gram.max()))


def test_a_number_without_an_effect_stays_and_the_others_are_found() -> None:
    t = np.linspace(0, 1, 50)

    def residual(x: Array) -> Array:
        return np.asarray(t * (x[0] - 1) + 0 * x[1])

    assert Squares(residual).least(np.zeros(2), 60) == pytest.approx([1.0, 0.0])
    assert Squares(lambda x: t + 0 * x).least(np.zeros(50), 60) == pytest.approx(np.zeros(50))


def test_numbers_that_end_where_nothing_has_an_effect_stay_there() -> None:
    """As those of an effect at its bounds."""

    def residual(x: Array) -> Array:
        return np.full(5, 2.0 - min(float(x[0]), 1.0))

    assert Squares(residual).least(np.zeros(1), 60)[0] >= 1.0


def test_a_number_of_little_effect_is_found_beside_one_of_much() -> None:
    t = np.linspace(0, 1, 50)

    def residual(x: Array) -> Array:
        return np.asarray(1e7 * (x[0] * t - t) + x[1] - 1)

    assert Squares(residual).least(np.zeros(2), 60) == pytest.approx([1.0, 1.0], abs=0.01)


def test_no_more_rounds_than_allowed() -> None:
    runs: list[Array] = []

    def residual(x: Array) -> Array:
        runs.append(x)
        return np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]])

    Squares(residual).least(np.array([-1.2, 1.0]), 3)
    assert len(runs) <= 3 * (1 + 2) + 1 + 2


def test_slopes_that_foretold_the_steps_are_taken_at_the_start_and_where_the_search_ends() -> None:
    """Of a nearly linear residual: at the start and where the search ended; 30 numbers cost 30 residuals each time."""
    rng, runs = np.random.default_rng(1), 0
    A, y = rng.normal(size=(400, 30)), rng.normal(size=400)

    def residual(x: Array) -> Array:
        nonlocal runs
        runs += 1
        left = A @ x - y
        return np.asarray(left + 1e-3 * left**2)

    best = Squares(residual).least(np.zeros(30), 60)
    assert runs < 3 * 30
    np.testing.assert_allclose(best, least_squares(residual, np.zeros(30)).x, atol=1e-3)
