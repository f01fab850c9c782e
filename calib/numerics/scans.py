"""Extremes, steps and repeats of a series in one pass over its rows, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array
from scenarios.kernel_cache import njit

Counts = NDArray[np.int64]


class Extremes(NamedTuple):
    """Least and greatest value (k,) of columns (n, k), the next value inwards, and how often each extreme occurs.

    `next_low` is +infinity and `next_high` -infinity for a column of one value.
    """

    low: Array
    next_low: Array
    low_count: Counts
    high: Array
    next_high: Array
    high_count: Counts


class RunCounts(NamedTuple):
    """Runs of equal rows: how many, how many of a single row, and the rows of the longest."""

    runs: int
    single: int
    longest: int


def extremes(columns: Array) -> Extremes:
    """Return the extremes of columns (n, k) without NaN."""
    return Extremes(*_ends(columns))


@njit(cache=True)
def _ends(columns: Array) -> tuple[Array, Array, Counts, Array, Array, Counts]:
    n, k = columns.shape
    low, beside_low, count_low = np.full(k, np.inf), np.full(k, np.inf), np.zeros(k, np.int64)
    high, beside_high, count_high = np.full(k, -np.inf), np.full(k, -np.inf), np.zeros(k, np.int64)
    for i in range(n):
        for j in range(k):
            value = columns[i, j]
            if value <= beside_low[j]:
                if value < low[j]:
                    low[j], beside_low[j], count_low[j] = value, low[j], 1
                elif value == low[j]:
                    count_low[j] += 1
                else:
                    beside_low[j] = value
            if value >= beside_high[j]:
                if value > high[j]:
                    high[j], beside_high[j], count_high[j] = value, high[j], 1
                elif value == high[j]:
                    count_high[j] += 1
                else:
                    beside_high[j] = value
    return low, beside_low, count_low, high, beside_high, count_high


@njit(cache=True, fastmath={"reassoc", "nnan"})
def largest_steps(columns: Array) -> Array:
    """Return the largest change (k,) from row to row of columns (n, k) without NaN."""
    n, k = columns.shape
    largest = np.zeros(k)
    for i in range(n - 1):
        for j in range(k):
            largest[j] = max(largest[j], abs(columns[i + 1, j] - columns[i, j]))
    return largest


@njit(cache=True)
def _counted_runs(columns: Array) -> tuple[int, int, int]:
    n, k = columns.shape
    runs, single, longest, first = 0, 0, 0, 0
    for i in range(1, n + 1):
        new = i == n
        for j in range(k):
            new = new or columns[i, j] != columns[i - 1, j]
        if new:
            runs += 1
            single += i - first == 1
            longest = max(longest, i - first)
            first = i
    return runs, single, longest


def run_counts(columns: Array) -> RunCounts:
    """Return the runs of equal rows in columns (n, k), n > 0."""
    return RunCounts(*_counted_runs(columns))


@njit(cache=True)
def zero_rows(columns: Array) -> int:
    """Return the number of rows of columns (n, k) that are zero throughout."""
    n, k = columns.shape
    count = 0
    for i in range(n):
        zero = True
        for j in range(k):
            zero = zero and columns[i, j] == 0.0
        count += zero
    return count


@njit(cache=True, fastmath={"reassoc", "nnan", "contract"})
def largest_antisymmetric(column: Array, weights: Array) -> float:
    """Return the largest |sum_j w_j (v_{i-1-j} - v_{i+j})| along values (n,), weights (m,): a filter that is odd."""
    m = len(weights)
    largest = 0.0
    for i in range(m, len(column) - m + 1):
        total = 0.0
        for j in range(m):
            total += weights[j] * (column[i - 1 - j] - column[i + j])
        largest = max(largest, abs(total))
    return largest
