"""Projections of columns on others, and least squares from their products on held-out folds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from calib.numerics.symmetric import symmetric_inverse
from scenarios.arrays import Array

GONE = 1e-10
"""Part of a column's square below which the remainder after projection is rounding."""


def project_out(base: Array, values: Array, *, common: bool = True) -> tuple[Array, Array]:
    """Values (n, q, j) with the base (n, q, p), in any units, projected out, and coefficients (q, p, j) of the base.

    Each output has coefficients of its own; in common, the outputs are further rows, and the coefficients (1, p, j).
    """
    n, q, _ = values.shape
    B, V = (columns.reshape(n * q, 1, columns.shape[2]) if common else columns for columns in (base, values))
    B, V = B.transpose(1, 0, 2), V.transpose(1, 0, 2)
    by_output = B.transpose(0, 2, 1)
    N = by_output @ B
    size = np.sqrt(np.maximum(np.einsum("qpp->qp", N), 1e-300))[:, :, None]
    through = symmetric_inverse(N / size / size.transpose(0, 2, 1), 1e-13) @ (by_output @ V / size) / size
    return (V - B @ through).transpose(1, 0, 2).reshape(values.shape), through


def without_rounding(left: Array, columns: Array) -> Array:
    """Projected columns (n, q, j), 0 where rounding is all that is left of the columns (n, q, j) before."""
    return np.asarray(left * ((left**2).sum(axis=(0, 1)) > GONE * (columns**2).sum(axis=(0, 1))))


def products(columns: Array) -> Array:
    """Products (j, j) of columns (n, q, j), summed over rows and outputs."""
    flat = columns.reshape(-1, columns.shape[2])
    return np.asarray(flat.T @ flat)


def solved(N: Array) -> Array:
    """Least-squares coefficients c (k,) from products (k + 1, k + 1) of columns and, last, the target."""
    size = np.sqrt(np.maximum(np.diag(N)[:-1], 1e-300))
    inverse = symmetric_inverse(N[:-1, :-1] / np.outer(size, size), 1e-9)
    return np.asarray(inverse @ (N[:-1, -1] / size) / size)


def squares_left(N: Array, c: Array) -> float:
    """Sum of squared residuals for coefficients c (k,), from products (k + 1, k + 1)."""
    v = np.append(c, -1.0)
    return float(v @ N @ v)


def explained_nats(N: Array) -> float:
    """Nats that the columns explain of the target in sample, in white noise of variance one."""
    return float(N[-1, -1] - squares_left(N, solved(N))) / 2


def held_out_squares(columns: Array, fold: NDArray[np.int64], folds: int) -> tuple[float, Array]:
    """Squares left of the target, the last of columns (n, q, j), on the folds (n,), each fitted to the other folds.

    With the products (j, j) over all folds.
    """
    each = np.stack([products(columns[fold == k]) for k in range(folds)])
    total = each.sum(axis=0)
    return sum(squares_left(N, solved(total - N)) for N in each), total
