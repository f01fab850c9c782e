"""White noise, slow noise and Allan deviation of series that a motion may be left in."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
LENGTHS_S = (1.0, 5.0, 20.0)
GAP = 1.5
"""Intervals, in medians, beyond which two samples are not neighbours."""
ORDERS = range(2, 7)
SETTLED = 0.98
"""A further difference that leaves more than this share takes out no more motion."""
BLOCK = 64
LEAST_BLOCKS = 4
LEAST_SAMPLES = 12
FILLED = 0.8
"""Share of its samples that a block must have."""


@dataclass(frozen=True)
class BlockMeans:
    """Means over `length_s`: `std` (k,) of them, and its `excess` (k,) over that of white noise, which is 1.

    excess = std sqrt(samples) / white_std;  a block has `samples`, there are `blocks`.
    """

    length_s: float
    samples: float
    blocks: int
    std: Array
    excess: Array

    def chance(self, sigmas: float = 4.0) -> float:
        """The largest excess that white noise has by chance, at so many standard deviations."""
        return float(np.sqrt(1.0 + sigmas * np.sqrt(2.0 / max(self.blocks - 1, 1))))


def gaps_after(time_s: Array) -> NDArray[np.intp]:
    """Indices of samples after which more than GAP median intervals of time_s (n,) pass."""
    step = np.diff(time_s)
    return np.flatnonzero(step > GAP * np.median(step)) if len(step) else np.zeros(0, np.intp)


def usual_interval(time_s: Array) -> float:
    """Mean interval of times (n,) between gaps, s: unlike the median it is not that of rounded time stamps."""
    step = np.diff(time_s)
    return float(step[step <= GAP * np.median(step)].mean()) if len(step) else float("nan")


def white_noise_std(values: Array, gaps: NDArray[np.intp] | None = None) -> Array:
    """Standard deviation (k,) of the white noise in values (n, k), see `white_noise`."""
    return white_noise(values, gaps)[0]


def white_noise(values: Array, gaps: NDArray[np.intp] | None = None) -> tuple[Array, NDArray[np.bool_]]:
    """Standard deviation (k,) of the white noise in values (n, k), from differences; whether they settled.

    sigma^2 = median over blocks of mean (D^p v)^2 / C(2p, p)

    p = 2, or higher as long as that takes out more motion; where it still does so at p = 6, noise has not settled and
    sigma is an upper bound. The median over blocks of 64 leaves spikes and bursts out and is right for values on a
    lattice too. gaps : samples after which a gap follows. NaN for fewer than 12 samples.
    """
    broken = np.zeros(max(len(values) - 1, 0))
    broken[gaps if gaps is not None else []] = 1.0
    found = np.array([_settled(column, broken) for column in values.T]).reshape(-1, 2)
    return found[:, 0], found[:, 1] > 0


def _settled(column: Array, broken: Array) -> tuple[float, float]:
    """The noise, and 1 if a further difference takes no more out."""
    if len(column) < LEAST_SAMPLES:
        return float("nan"), 0.0
    best = _from_differences(column, broken, ORDERS[0])
    for order in ORDERS[1:]:
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


def block_means(time_s: Array, residual: Array, lengths_s: tuple[float, ...] = LENGTHS_S) -> list[BlockMeans]:
    """Means of a residual (n, k) over blocks of time_s (n,), against its white noise; lengths with too few left out.

    Blocks must hold at least two samples and FILLED of what the median interval promises; four blocks at least.
    """
    if len(time_s) < LEAST_SAMPLES:
        return []
    interval_s = float(np.median(np.diff(time_s)))
    white = white_noise_std(residual, gaps_after(time_s))
    found = []
    for length_s in lengths_s:
        means, samples = _means(time_s, residual, length_s, interval_s)
        if len(means) >= LEAST_BLOCKS:
            std = means.std(axis=0, ddof=1)
            with np.errstate(divide="ignore", invalid="ignore"):
                excess = std * np.sqrt(samples) / white
            found.append(BlockMeans(length_s, samples, len(means), std, excess))
    return found


def _means(time_s: Array, residual: Array, length_s: float, interval_s: float) -> tuple[Array, float]:
    expected = length_s / interval_s
    if not expected >= 2:
        return np.zeros((0, residual.shape[1])), expected
    block = np.floor((time_s - time_s[0]) / length_s).astype(np.intp)
    sound = np.isfinite(residual).all(axis=1)
    counts = np.bincount(block[sound], minlength=int(block.max(initial=0)) + 1)
    sums = np.column_stack([np.bincount(block[sound], column[sound], minlength=len(counts)) for column in residual.T])
    full = counts >= FILLED * expected
    return sums[full] / counts[full, None], float(counts[full].mean()) if full.any() else expected


def allan_deviation(interval_s: float, values: Array) -> tuple[Array, Array]:
    """Averaging times (m,) in s, in octaves, and the overlapping Allan deviation (m, k) of values (n, k).

    sigma^2(tau) = <(ybar(t + tau) - ybar(t))^2> / 2, even sampling assumed, up to a quarter of the recording.
    """
    lengths = 2 ** np.arange(max(int(np.log2(max(len(values) // 4, 1))) + 1, 0))
    total = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values - values.mean(axis=0), axis=0)])
    deviations = []
    for length in lengths:
        second = total[2 * length :] - 2 * total[length:-length] + total[: -2 * length]
        deviations.append(np.sqrt(np.mean((second / length) ** 2, axis=0) / 2))
    return np.asarray(lengths * interval_s, np.float64), np.array(deviations).reshape(len(lengths), values.shape[1])
