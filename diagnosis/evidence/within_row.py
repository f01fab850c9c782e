"""Evidence from samples within a row, lost in the row's mean: fast tones, beside noise that is white within a row."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.evidence.binned_rows import BinnedRows
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array


def gain_within(problem: LinearProblem, rows: BinnedRows, accepted_columns: Sequence[Array], columns: Array) -> float:
    """Nats that columns (N, q, k) gain in samples less their row means, on held-out folds, beside the accepted columns.

    0 where the rows keep most of the columns' power. Slow noise is constant within a row and cancels, leaving white
    noise of variance one. Means and deviations are independent: their nats add up.
    """
    if len(rows.starts) == len(problem.target) or _kept(rows, columns) > problem.policy.half:
        return 0.0
    several = (_each_base(problem, rows), _joined(accepted_columns, columns), columns, problem.target[:, :, None])
    parts = [_about_means(rows, problem.usable, part) for part in several]
    y, E = (_without(parts[0], parts[1], part, common=rows.common) for part in (parts[3], parts[2]))
    fold = np.repeat(rows.fold, np.diff(np.append(rows.starts, len(problem.target))))
    products = [_sums(E[fold == k], y[fold == k]) for k in range(problem.policy.folds)]
    EE, Ey = (np.sum(both, axis=0) for both in zip(*products, strict=True))
    gained = 0.0
    for here, there in products:
        c = np.linalg.pinv(EE - here, rcond=1e-9, hermitian=True) @ (Ey - there)
        gained += float(c @ there - c @ here @ c / 2)
    return gained


def _kept(rows: BinnedRows, columns: Array) -> float:
    """Share of the columns' power that remains in row means."""
    total = float((columns**2).sum())
    return float((rows.bin(columns) ** 2).sum()) / total if total > 0 else 1.0


def _joined(accepted_columns: Sequence[Array], columns: Array) -> Array:
    """Groups of columns (N, q, .) side by side."""
    return np.concatenate([columns[:, :, :0], *accepted_columns], axis=2)


def _each_base(problem: LinearProblem, rows: BinnedRows) -> Array:
    """Base (N, q, p) of each output."""
    return problem.base if rows.common else np.repeat(problem.base[:, None], problem.target.shape[1], axis=1)


def _about_means(rows: BinnedRows, usable: Array, values: Array) -> Array:
    """Values (N, q, j) less the row mean of the usable values, 0 where not usable."""
    means = np.add.reduceat(values, rows.starts, axis=0) / np.maximum(rows.count, 1.0)[:, None, None]
    each = np.repeat(means, np.diff(np.append(rows.starts, len(values))), axis=0)
    return np.asarray((values - each) * usable[:, None, None])


def _without(base: Array, accepted_columns: Array, values: Array, *, common: bool) -> Array:
    """Values (N, q, j) with the base, then the columns of all outputs, projected out."""
    less = _less_in_common if common else _less
    free = less(base, values)
    if not accepted_columns.shape[2]:
        return free
    taken = less(base, accepted_columns)
    flat = taken.reshape(-1, taken.shape[2])
    c = np.linalg.lstsq(flat.T @ flat, flat.T @ free.reshape(len(flat), -1), rcond=1e-12)[0]
    return np.asarray(free - taken @ c)


def _less_in_common(base: Array, values: Array) -> Array:
    """Values (N, q, j) with a base of shared coefficients projected out."""
    flat = (values_of.reshape(-1, 1, values_of.shape[2]) for values_of in (base, values))
    return _less(*flat).reshape(values.shape)


def _less(base: Array, values: Array) -> Array:
    """Values (N, q, j) with the base of each output projected out."""
    BB = np.einsum("nqi,nqj->qij", base, base, optimize=True)
    through = np.linalg.pinv(BB, rcond=1e-13, hermitian=True) @ np.einsum("nqi,nqj->qij", base, values, optimize=True)
    return np.asarray(values - np.einsum("nqp,qpj->nqj", base, through, optimize=True))


def _sums(E: Array, y: Array) -> tuple[Array, Array]:
    flat = E.reshape(-1, E.shape[2])
    return flat.T @ flat, flat.T @ y.ravel()
