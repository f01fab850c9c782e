"""Evidence from samples within a row, lost in the row's mean: fast tones, beside noise that is white within a row."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.evidence.binned_rows import BinnedRows
from diagnosis.evidence.projections import held_out_squares, project_out, project_out_first
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array


def gain_within(problem: LinearProblem, rows: BinnedRows, accepted_columns: Sequence[Array], columns: Array) -> float:
    """Nats that columns (N, q, k) gain in samples less their row means, on held-out folds, beside the accepted columns.

    0 where the rows keep most of the columns' power. Slow noise is constant within a row and cancels, leaving white
    noise of variance one. Means and deviations are independent: their nats add up.
    """
    if len(rows.starts) == len(problem.target) or _kept(rows, columns) > problem.policy.half:
        return 0.0
    each_base = problem.base if rows.common else np.repeat(problem.base[:, None], problem.target.shape[1], axis=1)
    others = np.concatenate([*accepted_columns, columns, problem.target[:, :, None]], axis=2)
    base, others = (_about_means(rows, problem.usable, part) for part in (each_base, others))
    left = project_out_first(project_out(base, others, common=rows.common)[0], others.shape[2] - columns.shape[2] - 1)
    fold = np.repeat(rows.fold, np.diff(rows.starts, append=len(left)))
    squares, total = held_out_squares(left, fold, problem.policy.folds)
    return float(total[-1, -1] - squares) / 2


def _kept(rows: BinnedRows, columns: Array) -> float:
    """Share of the columns' power that remains in row means."""
    total = float((columns**2).sum())
    return float((rows.bin(columns) ** 2).sum()) / total if total > 0 else 1.0


def _about_means(rows: BinnedRows, usable: Array, values: Array) -> Array:
    """Values (N, q, j) less the row mean of the usable values, 0 where not usable."""
    means = np.add.reduceat(values, rows.starts, axis=0) / np.maximum(rows.count, 1.0)[:, None, None]
    each = np.repeat(means, np.diff(rows.starts, append=len(values)), axis=0)
    return np.asarray((values - each) * usable[:, None, None])
