"""How much of each leg: by hand where it can be, else against the optimal design, which needs no order and no moves."""

from __future__ import annotations

import numpy as np
import pytest

from validation.bound.limit import optimal
from validation.planning.allocation import LegInformation, whole


def legs(*rows: list[float], least: float = 0.0, unit_s: float = 1.0) -> LegInformation:
    each = np.array([np.outer(row, row) for row in rows])
    return LegInformation(np.zeros(each.shape[1:]), each, np.eye(each.shape[1]), least, unit_s)


def test_two_legs_by_hand() -> None:
    """1 / (9 x) + 1 / (10 - x) is least at x = 10 / 4."""
    amounts, square = legs([3.0, 0.0], [0.0, 1.0]).best(10.0)
    np.testing.assert_allclose(amounts, [2.5, 7.5], rtol=1e-3)
    assert square == pytest.approx(1 / 22.5 + 1 / 7.5, rel=1e-6)


def test_what_is_known_already_gets_no_time() -> None:
    each = np.array([np.diag([1.0, 0.0]), np.diag([0.0, 1.0])])
    amounts, _ = LegInformation(np.diag([4.0, 100.0]), each, np.eye(2), 0.0, 1.0).best(10.0)
    np.testing.assert_allclose(amounts, [10.0, 0.0], atol=1e-3)


def test_as_good_as_the_optimal_design() -> None:
    rows = np.random.default_rng(2).normal(size=(12, 4))
    best = optimal(rows[:, None, :], np.eye(4))[0]
    assert legs(*rows.tolist()).best(1.0)[1] == pytest.approx(best, rel=3e-3)


def test_too_little_time_is_infinite() -> None:
    assert legs([1.0, 0.0], [0.0, 1.0], least=1.0, unit_s=6.0).best(11.0)[1] == np.inf
    assert legs([1.0, 0.0], [1.0, 0.0]).best(10.0)[1] == np.inf


def test_whole_amounts_fit_and_hold_at_least_one() -> None:
    np.testing.assert_array_equal(whole(np.array([1.0, 2.7, 3.4, 1.9]), 9.0), [1.0, 3.0, 3.0, 2.0])
    np.testing.assert_array_equal(whole(np.array([1.2, 2.7, 3.6]), 8.4), [1.0, 3.0, 4.0])
    np.testing.assert_array_equal(whole(np.array([0.2, 0.9, 1.5]), 2.0), [1.0, 1.0, 1.0])


def test_the_least_of_a_leg_is_kept_and_a_unit_has_its_length() -> None:
    """1 / (9 x) + 1 / (5 - x) is least at 1.25, below what a leg must have; a unit lasts two seconds."""
    amounts, square = legs([3.0, 0.0], [0.0, 1.0], least=2.0, unit_s=2.0).best(10.0)
    np.testing.assert_allclose(amounts, [2.0, 3.0], rtol=1e-3)
    assert square == pytest.approx(1 / 18 + 1 / 3, rel=1e-4)
    assert np.isfinite(legs([3.0, 0.0], [0.0, 1.0], least=2.0, unit_s=2.0).best(8.0)[1])


def test_the_slope_is_that_of_small_steps() -> None:
    rng = np.random.default_rng(6)
    some, amounts = legs(*rng.normal(size=(5, 3)).tolist()), rng.uniform(1.0, 2.0, 5)
    _, slope = some._log_and_slope(amounts)
    steps = 1e-6 * np.eye(5)
    values = [(some._log_and_slope(amounts + d)[0], some._log_and_slope(amounts - d)[0]) for d in steps]
    np.testing.assert_allclose(slope, [(up - down) / 2e-6 for up, down in values], rtol=1e-5)
    assert np.exp(some._log_and_slope(amounts)[0]) == pytest.approx(some.mean_square(amounts))
