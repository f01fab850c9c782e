"""Rows of a problem: means of neighbouring samples at their true times, cut into folds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from diagnosis.policy import Policy
from scenarios.arrays import Array
from sim.effects.kernels import kernel
from validation.signals.bands import Bands


@dataclass(frozen=True, eq=False)
class BinnedRows:
    """N samples binned into n rows, at most `most_rows`; the variance of white noise is kept.

    time_s (N,), usable (N,): of the samples. base (n, q, p), target (n, q): of the rows; `common`: the q outputs share
    the base's coefficients. output_axes (n, q, 3): directions of the outputs in the sensor frame over the noise of each
    output, the first output having unit length. segment_s: length of a fold's segment.
    """

    time_s: Array
    usable: Array
    starts: NDArray[np.int64]
    base: Array
    target: Array
    policy: Policy
    segment_s: float
    common: bool
    output_axes: Array | None = None

    @classmethod
    def of(
        cls, time_s: Array, usable: Array, base: Array, target: Array, policy: Policy, output_axes: Array | None = None
    ) -> BinnedRows:
        """Rows of samples: base (N, p), or (N, q, p) with shared coefficients; target (N, q), 0 where not usable."""
        starts = np.arange(0, len(time_s), -(-len(time_s) // policy.most_rows))
        passed_s = float(time_s[starts[-1]] - time_s[0])
        segment_s = min(max(policy.fold_s, policy.fold_share * passed_s), passed_s / (2 * policy.folds))
        rows = cls(time_s, usable, starts, base, target, policy, segment_s, base.ndim == 3)
        each = base if rows.common else np.repeat(base[:, None], target.shape[1], axis=1)
        if output_axes is not None:
            output_axes = np.add.reduceat(output_axes, starts) / np.diff(starts, append=len(time_s))[:, None, None]
        return replace(rows, base=rows.bin(each), target=rows.bin(target), output_axes=output_axes)

    def bin(self, values: Array) -> Array:
        """Row sums (n, ...) of values (N, ...) over the root of the number of usable samples."""
        total = _sums(values.reshape(len(values), math.prod(values.shape[1:])), self.starts)
        root = np.sqrt(np.maximum(self.count, 1.0))[:, None]
        return np.asarray((total / root).reshape(len(total), *values.shape[1:]))

    def bin_groups(self, several: Sequence[Array]) -> Array:
        """Rows (n, q, .) of several groups of columns (N, q, k), side by side."""
        none = np.zeros((len(self.starts), self.target.shape[1], 0))
        return np.concatenate([none, *map(self.bin, several)], axis=2)

    def bands(self, residual: Array) -> Bands:
        """Spectrum of a residual (n, q) from the first line on, where a random walk over the whole run is largest."""
        return Bands.of(residual, self.interval_s, 1, self.policy.bands)

    def in_common(self) -> BinnedRows:
        """The rows with the base of all outputs in one of shared coefficients, (n, q, q p)."""
        if self.common:
            return self
        base = np.einsum("nap,ab->nabp", self.base, np.eye(self.base.shape[1]))
        return replace(self, base=base.reshape(*self.target.shape, -1), common=True)

    @cached_property
    def count(self) -> Array:
        """Usable samples (n,) of each row."""
        return np.asarray(np.add.reduceat(self.usable, self.starts))

    @property
    def row_start_s(self) -> Array:
        """Time (n,) of the first sample of each row."""
        return self.time_s[self.starts]

    @property
    def interval_s(self) -> float:
        """Median time between two rows."""
        return float(np.median(np.diff(self.row_start_s)))

    @cached_property
    def segment(self) -> NDArray[np.int64]:
        """Segment (n,) of each row."""
        return np.asarray(((self.row_start_s - self.row_start_s[0]) // self.segment_s).astype(np.int64))

    @property
    def fold(self) -> NDArray[np.int64]:
        """Fold (n,) of each row: segments are assigned to the folds in turn."""
        return np.asarray(self.segment % self.policy.folds)

    def refine_folds(self, columns: Array) -> BinnedRows:
        """The rows with segments so short that each column of (n, q, k) acts in as many segments as there are folds.

        An event within a single segment would be held out whole. The number of segments is ``(sum e)^2 / sum e^2``, e a
        column's power in each.
        """
        power = (columns**2).sum(axis=1)
        power = power[:, power.any(axis=0)].T
        rows = self
        while rows.segment_s > 2 * self.policy.least_segment_s:
            e = np.stack([np.bincount(rows.segment, column) for column in power])
            if (e.sum(axis=1) ** 2 >= self.policy.folds * (e**2).sum(axis=1)).all():
                break
            rows = replace(self, segment_s=rows.segment_s / 2)
        return rows


@kernel
def _sums(values: Array, starts: NDArray[np.int64]) -> Array:
    """Sums (n, k) of values (N, k) from each start to the next."""
    out = np.zeros((len(starts), values.shape[1]))
    for row in range(len(starts)):
        for i in range(starts[row], starts[row + 1] if row + 1 < len(starts) else len(values)):
            for j in range(values.shape[1]):
                out[row, j] += values[i, j]
    return out
