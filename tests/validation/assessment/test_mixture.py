"""Posterior of offset and disturbances against least squares written again, and against drawn disturbances."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.arrays import Array
from validation.assessment.mixture import Component, LegSquares, mixture
from validation.assessment.policy import ASSESSMENT

LEGS, ROWS, F = 20, 400, 50_000.0
GROUPS = ("iron",) * 2 + ("characteristic",) * 2 + ("motors",)


def columns(rng: np.random.Generator) -> Array:
    return rng.normal(size=(ROWS, len(GROUPS)))


def squares_of(X: Array, y: Array) -> LegSquares:
    rows = np.column_stack((X, y)).reshape(LEGS, -1, len(GROUPS) + 1)
    wanted = np.eye(2, len(GROUPS))
    none = np.zeros(len(GROUPS))
    return LegSquares(np.einsum("lri,lrj->lij", rows, rows), GROUPS, ROWS, wanted, none, none, F)


def test_without_disturbances_the_posterior_is_least_squares() -> None:
    rng = np.random.default_rng(0)
    X = columns(rng)
    y = X[:, :2] @ [30.0, -20.0] + rng.normal(0, 50.0, ROWS)
    found = squares_of(X, y).solved({})
    estimate, rest = np.linalg.lstsq(X[:, :2], y, rcond=None)[:2]
    assert found.mean == pytest.approx([*estimate, 0.0, 0.0, 0.0])
    assert found.noise_nT2 == pytest.approx(rest[0] / (ROWS - 2))
    expected = found.scatter * found.noise_nT2 * np.linalg.inv(X[:, :2].T @ X[:, :2])
    assert found.covariance[:2, :2] == pytest.approx(expected)


def test_white_noise_scatters_as_white_and_errors_of_whole_legs_more() -> None:
    rng = np.random.default_rng(1)
    X, white = columns(rng), rng.normal(0, 50.0, ROWS)
    X[:, 0] = 1.0
    by_leg = np.repeat(rng.normal(0, 50.0, LEGS), ROWS // LEGS)
    assert squares_of(X, white).solved({}).scatter < 2.0
    assert squares_of(X, white + by_leg).solved({}).scatter > 4.0


def test_a_disturbance_is_found_where_it_is_and_absent_where_it_is_not() -> None:
    rng = np.random.default_rng(2)
    X = columns(rng)
    noise = rng.normal(0, 50.0, ROWS)
    with_motors = max(mixture(squares_of(X, noise + 100.0 * X[:, 4])), key=lambda one: one.weight)
    without = max(mixture(squares_of(X, noise)), key=lambda one: one.weight)
    assert with_motors.spreads["motors"] > 0
    assert with_motors.mean[4] == pytest.approx(100.0, abs=15.0)
    assert without.spreads == {"motors": 0.0, "characteristic": 0.0}


def test_the_weights_add_up_and_draws_have_mean_and_spread() -> None:
    rng = np.random.default_rng(3)
    X = columns(rng)
    found = mixture(squares_of(X, rng.normal(0, 50.0, ROWS) + 8.0 * X[:, 2]))
    assert sum(one.weight for one in found) == pytest.approx(1.0)
    assert all(one.weight >= ASSESSMENT.least_weight for one in found)
    drawn = found[0].drawn(20_000, rng)
    assert drawn.mean(axis=0)[:2] == pytest.approx(found[0].mean[:2], abs=0.1)
    heavy = found[0].freedom / (found[0].freedom - 2.0)
    assert np.var(drawn[:, 0]) == pytest.approx(heavy * found[0].covariance[0, 0], rel=0.1)


def test_a_prior_holds_a_parameter_that_the_rows_do_not_show() -> None:
    rng = np.random.default_rng(4)
    X = columns(rng)
    X[:, 1] = 0.0
    plain = squares_of(X, rng.normal(0, 50.0, ROWS))
    firm, centre = np.array([0.0, 1 / 300.0**2, 0, 0, 0]), np.array([0.0, 70.0, 0, 0, 0])
    held = LegSquares(plain.squares, GROUPS, ROWS, plain.wanted, firm, centre, F).solved({})
    assert held.mean[1] == pytest.approx(70.0)
    assert np.sqrt(held.covariance[1, 1]) == pytest.approx(300.0, rel=0.1)


def test_draws_of_next_to_no_freedom_are_numbers() -> None:
    """A chi-square of a hundredth of a degree of freedom is zero in a third of the draws."""
    one = Component(1.0, np.zeros(2), np.eye(2), 0.01, 1.0, 1.0, {})
    drawn = one.drawn(500, np.random.default_rng(1))
    assert np.isfinite(drawn).all()
    assert np.abs(drawn).max() > 1e3
