"""Slow noise of a residual: block means compared with white noise, and the Allan deviation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from calib.numerics.noise import LEAST_BLOCKS, LEAST_SAMPLES, white_noise_std
from scenarios.arrays import Array
from validation.policy import POLICY
from validation.signals.intervals import gaps_after


@dataclass(frozen=True)
class BlockMeans:
    """Means over `length_s`: standard deviation `std` (k,), and `excess` (k,) over means of white noise, which have 1.

    excess = std sqrt(samples) / white_std;  `blocks` blocks have `samples` samples each.
    """

    length_s: float
    samples: float
    blocks: int
    std: Array
    excess: Array

    def chance(self) -> float:
        """Return the largest excess of white noise by chance, 4 standard deviations of the variance above 1."""
        return float(np.sqrt(1.0 + POLICY.excess_sigma * np.sqrt(2.0 / max(self.blocks - 1, 1))))


def block_means(
    time_s: Array, residual: Array, lengths_s: tuple[float, ...] = POLICY.mean_lengths_s
) -> list[BlockMeans]:
    """Return means of a residual (n, k) over blocks of time_s (n,) compared with white noise, for each length.

    A block needs two samples and 80 % of the samples that the median interval gives; a length needs four blocks.
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
    sound = np.isfinite(residual).all(axis=1)
    _, block = np.unique(np.floor((time_s[sound] - time_s[0]) / length_s), return_inverse=True)
    counts = np.bincount(block)
    sums = np.column_stack([np.bincount(block, column[sound], minlength=len(counts)) for column in residual.T])
    full = counts >= POLICY.filled_mean * expected
    return sums[full] / counts[full, None], float(counts[full].mean()) if full.any() else expected


def allan_deviation(interval_s: float, values: Array) -> tuple[Array, Array]:
    """Return averaging times (m,) in s and the overlapping Allan deviation (m, k) of evenly sampled values (n, k).

    sigma^2(tau) = <(ybar(t + tau) - ybar(t))^2> / 2, in octaves up to a quarter of the recording.
    """
    lengths = 2 ** np.arange(max(int(np.log2(max(len(values) // 4, 1))) + 1, 0))
    total = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values - values.mean(axis=0), axis=0)])
    deviations = []
    for length in lengths:
        second = total[2 * length :] - 2 * total[length:-length] + total[: -2 * length]
        deviations.append(np.sqrt(np.mean((second / length) ** 2, axis=0) / 2))
    return np.asarray(lengths * interval_s, np.float64), np.array(deviations).reshape(len(lengths), values.shape[1])
