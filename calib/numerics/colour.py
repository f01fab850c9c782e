"""Residuals that are not white: how much surer a covariance pretends to be than the data allow."""

from __future__ import annotations

import numpy as np
from scipy.special import ndtri, stdtrit

from scenarios.arrays import Array
from scenarios.kernel_cache import njit

BLOCKS = (20, 50, 200)
"""Numbers of blocks that a recording is cut into: slow structure shows in the means of few, faster in those of many."""
LEAST_BLOCK = 10
CHANCE = 4.0
"""Excess of a block mean's variance, in its standard deviations under white noise, that is taken for colour."""

MANY = 100
"""Degrees of freedom of the noise beyond which Student's t is a normal distribution, to 1.2 % of a 95 % interval."""


def inflation(residual: Array) -> float:
    """Factor V >= 1 by which a covariance claimed for white residuals (n,) or (n, k), in order of time, is too small.

    V = max over block lengths L of W_L = L var(block means) / var(residual), which is 1 for white noise; a W_L within
    CHANCE standard deviations (sqrt(2 / blocks / k)) of 1 counts as 1.
    """
    columns = np.ascontiguousarray(residual).reshape(len(residual), -1)
    worst = 1.0
    for blocks, ratio in _excess(columns).items():
        if ratio > 1.0 + CHANCE * np.sqrt(2.0 / (blocks * columns.shape[1])):
            worst = max(worst, ratio)
    return worst


def few_factor(freedom: float) -> float:
    """Factor on a covariance, (t / z)^2, by which 95 % of a normal distribution are 95 % of Student's t.

    freedom : of the variance: residuals less parameters, or of flicker noise; 1 for more than MANY
    """
    if freedom > MANY:
        return 1.0
    return float((stdtrit(max(freedom, 1.0), 0.975) / ndtri(0.975)) ** 2)


def white_ratios(total: Array, count: Array) -> Array:
    """W = T^2 / n (m, k) of sums T (m, k) over blocks of n (m,) samples: chi squared of mean 1 in unit white noise.

    Their mean is the W_L of `inflation`, for residuals that only their sums over blocks are known of.
    """
    return np.asarray(total**2 / count[:, None])


def _excess(columns: Array) -> dict[int, float]:
    """W_L of columns (n, k) by number of blocks; none for residuals that vanish."""
    n = len(columns)
    variance = float(block_mean_square(columns, n))
    usable = [blocks for blocks in BLOCKS if n // blocks >= LEAST_BLOCK and variance > 0.0]
    return {blocks: n // blocks * float(block_mean_square(columns, blocks)) / variance for blocks in usable}


@njit(cache=True, fastmath={"reassoc", "contract"})
def block_mean_square(columns: Array, blocks: int) -> float:
    """Mean square, about the mean of all, of the means over equally long blocks of columns (n, k); blocks <= n."""
    n, k = columns.shape
    length, total = n // blocks, 0.0
    for j in range(k):
        middle = 0.0
        for i in range(n):
            middle += columns[i, j]
        middle /= n
        for first in range(0, blocks * length, length):
            mean = 0.0
            for i in range(first, first + length):
                mean += columns[i, j]
            total += (mean / length - middle) ** 2
    return float(total / (blocks * k))
