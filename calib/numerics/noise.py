"""White noise of a series from differences: the common estimate of calibrators, inspection and diagnosis."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import comb

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array

ORDERS = (2, 3, 4, 5, 6)
"""Orders of difference that are tried on a series with motion in it: p = 6 takes out any polynomial of degree 5."""
SECOND = (2,)
"""For a residual, whose motion a model has taken out: a filter's coloured noise must not pass for motion."""
SETTLED = 0.98
"""A further difference that leaves more than this share of the noise takes out no more motion."""
BLOCK = 64
LEAST_BLOCKS = 4
LEAST_SAMPLES = 12
CLIP = 4.0
NORMAL_MEDIAN = 0.6744897501960817
"""Median of |x| of a standard normal x."""
Pooled = Callable[[Array, int], Array]
"""From sizes (m, k) of errors, and the order of the differences that gave them, to their rms (k,)."""


def white_noise_std(
    values: Array, gaps: NDArray[np.intp] | None = None, *, orders: Sequence[int] = ORDERS, pooled: Pooled | None = None
) -> Array:
    """Standard deviation (k,) of the white noise in values (n, k), see `white_noise`."""
    return white_noise(values, gaps, orders=orders, pooled=pooled)[0]


def white_noise(
    values: Array, gaps: NDArray[np.intp] | None = None, *, orders: Sequence[int] = ORDERS, pooled: Pooled | None = None
) -> tuple[Array, NDArray[np.bool_]]:
    """Standard deviation (k,) of the white noise in values (n, k), from differences; whether they settled.

    sigma = rms of D^p v / sqrt(C(2p, p)),  pooled robustly

    p is the first of `orders`, or a later one as long as that takes out more motion; where the last still does so, the
    noise has not settled and sigma is an upper bound. gaps : samples after which a gap follows. pooled :
    `median_of_blocks` if none is given. Rows that a slower sensor repeats are to be left out by the caller. NaN for
    fewer than 12 samples.
    """
    columns = values.shape[1]
    if len(values) < LEAST_SAMPLES:
        return np.full(columns, np.nan), np.zeros(columns, np.bool_)
    pool = pooled or median_of_blocks
    best, falling = pool(_differences(values, gaps, orders[0]), orders[0]), np.ones(columns, np.bool_)
    for order in orders[1:]:
        lower = pool(_differences(values, gaps, order), order)
        falling &= lower < SETTLED * best
        best = np.where(falling, lower, best)
    return best, ~falling


def _differences(values: Array, gaps: NDArray[np.intp] | None, order: int) -> Array:
    """Sizes (m, k) of the differences of an order within unbroken stretches, in units of the noise."""
    broken = np.zeros(len(values) - 1)
    broken[gaps if gaps is not None else []] = 1.0
    size = np.abs(np.diff(values, order, axis=0)) / np.sqrt(comb(2 * order, order))
    sound = (np.convolve(broken, np.ones(order), "valid") == 0) & np.isfinite(size).all(axis=1)
    return np.asarray(size[sound])


def median_of_blocks(size: Array, order: int) -> Array:
    """Rms (k,) of sizes (m, k) by the median over blocks of 64: spikes and bursts stay out, a lattice does no harm."""
    length = BLOCK if len(size) >= LEAST_BLOCKS * BLOCK else max(4, len(size) // LEAST_BLOCKS)
    blocks = len(size) // length
    if blocks == 0:
        return np.full(size.shape[1], np.nan)
    square = size[: blocks * length].reshape(blocks, length, -1) ** 2
    return np.asarray(np.sqrt(np.median(square.mean(axis=1), axis=0) / _median_share(length, order)))


def clipped_mean(size: Array, order: int) -> Array:
    """Rms (k,) of sizes (m, k), those beyond four robust standard deviations counted as four.

    The surest where faults are single and rare; a burst or a lattice coarser than the noise misleads it.
    """
    robust = np.median(size, axis=0) / NORMAL_MEDIAN
    rms = np.sqrt((np.minimum(size, CLIP * robust) ** 2).mean(axis=0))
    return np.asarray(np.where(rms > 0, rms, size.std(axis=0)))


def _median_share(length: int, order: int) -> float:
    """Median over mean of the mean of `length` correlated squares: that of chi squared with as many free values."""
    weights = np.array([comb(2 * order, order + lag) / comb(2 * order, order) for lag in range(1, order + 1)])
    free = length / (1.0 + 2.0 * float(weights @ weights))
    return float((1.0 - 2.0 / (9.0 * free)) ** 3)
