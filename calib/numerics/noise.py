"""White noise of a series from its differences: the one estimate that calibrators, inspection and diagnosis share."""

from __future__ import annotations

from collections.abc import Sequence
from math import comb

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ORDERS = (2, 3, 4, 5, 6)
"""Orders of difference that are tried on a series with motion in it: p = 6 takes out any polynomial of degree 5."""
SECOND = (2,)
"""For a residual, whose motion a model has taken out: a filter's coloured noise must not pass for motion."""
SETTLED = 0.98
"""A further difference that leaves more than this share of the noise takes out no more motion."""
BLOCK = 64
LEAST_BLOCKS = 4
LEAST_SAMPLES = 12


def white_noise_std(values: Array, gaps: NDArray[np.intp] | None = None, *, orders: Sequence[int] = ORDERS) -> Array:
    """Standard deviation (k,) of the white noise in values (n, k), see `white_noise`."""
    return white_noise(values, gaps, orders=orders)[0]


def white_noise(
    values: Array, gaps: NDArray[np.intp] | None = None, *, orders: Sequence[int] = ORDERS
) -> tuple[Array, NDArray[np.bool_]]:
    """Standard deviation (k,) of the white noise in values (n, k), from differences; whether they settled.

    sigma^2 = median over blocks of mean (D^p v)^2 / C(2p, p)

    p is the first of `orders`, or a later one as long as that takes out more motion; where the last still does so, the
    noise has not settled and sigma is an upper bound. The median over blocks of 64 leaves spikes and bursts out and is
    right for values on a lattice too. gaps : samples after which a gap follows. Rows that a slower sensor repeats are
    to be left out by the caller. NaN for fewer than 12 samples.
    """
    broken = np.zeros(max(len(values) - 1, 0))
    broken[gaps if gaps is not None else []] = 1.0
    found = np.array([_settled(column, broken, orders) for column in values.T]).reshape(-1, 2)
    return found[:, 0], found[:, 1] > 0


def _settled(column: Array, broken: Array, orders: Sequence[int]) -> tuple[float, float]:
    """The noise, and 1 if a further difference takes no more out."""
    if len(column) < LEAST_SAMPLES:
        return float("nan"), 0.0
    best = _from_differences(column, broken, orders[0])
    for order in orders[1:]:
        lower = _from_differences(column, broken, order)
        if not lower < SETTLED * best:
            return best, 1.0
        best = lower
    return best, 0.0


def _from_differences(column: Array, broken: Array, order: int) -> float:
    square = np.diff(column, order) ** 2 / comb(2 * order, order)
    sound = np.convolve(broken, np.ones(order), "valid") == 0
    square = square[sound & np.isfinite(square)]
    length = BLOCK if len(square) >= LEAST_BLOCKS * BLOCK else max(4, len(square) // LEAST_BLOCKS)
    blocks = len(square) // length
    if blocks == 0:
        return float("nan")
    means = square[: blocks * length].reshape(blocks, length).mean(axis=1)
    return float(np.sqrt(np.median(means) / _median_share(length, order)))


def _median_share(length: int, order: int) -> float:
    """Median over mean of the mean of `length` correlated squares: that of chi squared with as many free values."""
    weights = np.array([comb(2 * order, order + lag) / comb(2 * order, order) for lag in range(1, order + 1)])
    free = length / (1.0 + 2.0 * float(weights @ weights))
    return float((1.0 - 2.0 / (9.0 * free)) ** 3)
