"""A problem in rows: means of neighbouring samples with their true times, cut into folds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from diagnosis.policy import Policy
from scenarios.arrays import Array


@dataclass(frozen=True, eq=False)
class BinnedRows:
    """Samples (N,) taken together so that no series is longer than `most_rows`; white noise keeps its variance.

    time_s (N,), usable (N,) of the samples; base (n, q, p) and target (n, q) of the rows, each output with its base,
    whose coefficients the outputs have in common or of their own;
    sight (n, q, 3): how the outputs see a vector of which they are parts, each over its noise, the first as 1; fold_s:
    length of a segment of a fold, 0: the policy's.
    """

    time_s: Array
    usable: Array
    starts: NDArray[np.int64]
    base: Array
    target: Array
    policy: Policy
    sight: Array | None = None
    fold_s: float = 0.0
    common: bool = False

    @classmethod
    def of(
        cls,
        time_s: Array,
        usable: Array,
        base: Array,
        target: Array,
        policy: Policy,
        sight: Array | None = None,
    ) -> BinnedRows:
        """The rows of samples: base (N, p), or (N, q, p) with common coefficients, target (N, q), 0 if not usable."""
        starts = np.arange(0, len(time_s), -(-len(time_s) // policy.most_rows))
        rows = cls(time_s, usable, starts, np.zeros(0), np.zeros(0), policy)
        each = base if base.ndim == 3 else np.repeat(base[:, None], target.shape[1], axis=1)
        along = None if sight is None else _means(sight, starts)
        taken = rows.taken(each), rows.taken(target)
        return cls(time_s, usable, starts, *taken, policy, along, common=base.ndim == 3)

    def taken(self, values: Array) -> Array:
        """Sums (n, ...) of values (N, ...) over rows, over the root of their number of usable samples."""
        root = np.sqrt(np.maximum(self.count, 1.0))
        return np.asarray(np.add.reduceat(values, self.starts, axis=0) / root.reshape(-1, *[1] * (values.ndim - 1)))

    def all_taken(self, several: Sequence[Array]) -> Array:
        """The same (n, q, .) of several groups of columns (N, q, k), one behind the other."""
        none = np.zeros((len(self.starts), self.target.shape[1], 0))
        return np.concatenate([none, *map(self.taken, several)], axis=2)

    @cached_property
    def count(self) -> Array:
        """Usable samples (n,) of each row."""
        return np.asarray(np.add.reduceat(self.usable, self.starts))

    @property
    def row_s(self) -> Array:
        """Time (n,) of each row's first sample."""
        return self.time_s[self.starts]

    @property
    def interval_s(self) -> float:
        """Time between two rows, the median."""
        return float(np.median(np.diff(self.row_s)))

    @property
    def segment_s(self) -> float:
        """Length of a segment of a fold."""
        passed_s = float(self.row_s[-1] - self.row_s[0])
        longest_s = passed_s / (2 * self.policy.folds)
        return self.fold_s or min(max(self.policy.fold_s, self.policy.fold_share * passed_s), longest_s)

    @cached_property
    def segment(self) -> NDArray[np.int64]:
        """The segment (n,) of each row."""
        return np.asarray(((self.row_s - self.row_s[0]) // self.segment_s).astype(np.int64))

    @property
    def fold(self) -> NDArray[np.int64]:
        """The fold (n,) of each row: segments of time go round."""
        return np.asarray(self.segment % self.policy.folds)

    def showing(self, columns: Array) -> BinnedRows:
        """The same rows in segments short enough that each column of (n, q, k) acts in as many as there are folds.

        An event within one segment would be held out whole. The number is ``(sum e)^2 / sum e^2``, e a column's power
        in each segment.
        """
        power = (columns**2).sum(axis=1)
        power = power[:, power.any(axis=0)].T
        rows = self
        while rows.segment_s > 2 * self.policy.least_segment_s:
            e = np.stack([np.bincount(rows.segment, one) for one in power])
            if (e.sum(axis=1) ** 2 >= self.policy.folds * (e**2).sum(axis=1)).all():
                break
            rows = replace(self, fold_s=rows.segment_s / 2)
        return rows


def _means(values: Array, starts: NDArray[np.int64]) -> Array:
    """Means (n, ...) of values (N, ...) from each start to the next."""
    return np.asarray(np.add.reduceat(values, starts, axis=0) / np.diff(starts, append=len(values))[:, None, None])
