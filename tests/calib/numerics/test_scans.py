"""Scans in one pass against numpy's passes, on noise and on values that repeat."""

from __future__ import annotations

import numpy as np
import pytest

from calib.numerics.scans import extremes, largest_antisymmetric, largest_steps, run_counts, zero_rows

NOISE = np.random.default_rng(0).normal(0.0, 100.0, (500, 3))
CASES = {"noise": NOISE, "coarse": np.round(NOISE, -2), "constant": np.zeros((20, 3)), "one row": NOISE[:1]}


@pytest.mark.parametrize("values", CASES.values(), ids=CASES)
def test_extremes_are_those_of_sorted_values(values: np.ndarray) -> None:
    found = extremes(values)
    for axis, column in enumerate(values.T):
        distinct, counts = np.unique(column, return_counts=True)
        assert (found.low[axis], found.low_count[axis]) == (distinct[0], counts[0])
        assert (found.high[axis], found.high_count[axis]) == (distinct[-1], counts[-1])
        beside = (distinct[1], distinct[-2]) if len(distinct) > 1 else (np.inf, -np.inf)
        assert (found.next_low[axis], found.next_high[axis]) == beside


@pytest.mark.parametrize("values", CASES.values(), ids=CASES)
def test_steps_and_runs_are_those_of_differences(values: np.ndarray) -> None:
    step = np.diff(values, axis=0)
    np.testing.assert_array_equal(largest_steps(values), np.abs(step).max(axis=0, initial=0.0))
    for columns, changed in ((values, step.any(axis=1)), (values[:, :1], step[:, 0] != 0)):
        length = np.diff(np.r_[0, np.flatnonzero(changed) + 1, len(values)])
        assert run_counts(columns) == (len(length), np.count_nonzero(length == 1), length.max())
    assert zero_rows(values) == np.count_nonzero(~values.any(axis=1))


def test_an_odd_filter_is_a_correlation() -> None:
    weights = np.array([0.5, 0.25, -0.1])
    whole = np.r_[weights[::-1], -weights]
    column = np.ascontiguousarray(NOISE[:, 0])
    expected = np.abs(np.correlate(column, whole, "valid")).max()
    assert largest_antisymmetric(column, weights) == pytest.approx(expected, rel=1e-12)
    assert largest_antisymmetric(column[:5], weights) == 0.0
