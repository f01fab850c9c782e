"""A problem in rows: means of neighbouring samples with their true times, cut into folds."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from sim.state import Array
from validation.diagnosis.policy import Policy


@dataclass(frozen=True, eq=False)
class Rows:
    """Samples (N,) taken together so that no series is longer than `most_rows`; white noise keeps its variance.

    time_s (N,), usable (N,) of the samples; base (n, q, p) and target (n, q) of the rows, each output with its base.
    """

    time_s: Array
    usable: Array
    starts: NDArray[np.int64]
    base: Array
    target: Array
    policy: Policy

    @classmethod
    def of(cls, time_s: Array, usable: Array, base: Array, target: Array, policy: Policy) -> Rows:
        """The rows of samples: base (N, p) for all outputs or (N, q, p), target (N, q), 0 where nothing is usable."""
        starts = np.arange(0, len(time_s), -(-len(time_s) // policy.most_rows))
        rows = cls(time_s, usable, starts, np.zeros(0), np.zeros(0), policy)
        each = base if base.ndim == 3 else np.repeat(base[:, None], target.shape[1], axis=1)
        return cls(time_s, usable, starts, rows.taken(each), rows.taken(target), policy)

    def taken(self, values: Array) -> Array:
        """Sums (n, ...) of values (N, ...) over rows, over the root of their number of usable samples."""
        root = np.sqrt(np.maximum(self.count, 1.0))
        return np.asarray(np.add.reduceat(values, self.starts, axis=0) / root.reshape(-1, *[1] * (values.ndim - 1)))

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

    @cached_property
    def fold(self) -> NDArray[np.int64]:
        """The fold (n,) of each row: segments of time go round."""
        passed_s = self.row_s - self.row_s[0]
        length_s = max(self.policy.fold_s, self.policy.fold_share * float(passed_s[-1]))
        length_s = min(length_s, float(passed_s[-1]) / (2 * self.policy.folds))
        return np.asarray((passed_s // length_s).astype(np.int64) % self.policy.folds)
