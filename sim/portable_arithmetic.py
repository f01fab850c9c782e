"""Arithmetic with equal bits on every processor, for the bytes of a dataset.

BLAS and LAPACK (`@`, `np.linalg`) choose kernels by the processor, and so does numpy for exp, powers and arc
functions of float64. Sums and products in a fixed order, sqrt, sin and cos give equal bits on every processor with
fused multiply-add; on older processors the C library's sin and cos differ, the engine's too.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from scenarios.arrays import Array


def extended(values: Any) -> Any:
    """The numbers in extended precision, whose functions and sums no vector unit computes.

    For a library's function, or numpy's exp and powers; the caller rounds the result to float64.
    """
    return np.asarray(values, dtype=np.longdouble)


def product(a: Array, b: Array) -> Array:
    """A B (..., n, k) of A (..., n, m) and B (..., m, k)."""
    terms = [a[..., :, j, None] * b[..., j, None, :] for j in range(a.shape[-1])]
    total: Array = sum(terms[1:], terms[0])
    return total


def inverse(a: Array) -> Array:
    """Inverse of a symmetric positive definite matrix (n, n), by Gauss and Jordan's elimination (no pivots needed)."""
    n = len(a)
    rows = np.concatenate([a, np.eye(n)], axis=1)
    for k in range(n):
        rows[k] /= rows[k, k]
        others = np.arange(n) != k
        rows[others] -= rows[others, k, None] * rows[k]
    return np.ascontiguousarray(rows[:, n:])


def pseudo_inverse(a: Array) -> Array:
    """A^T (A A^T)^-1 (m, n) of a matrix (n, m) with independent rows: A^+ b is the shortest solution of A x = b."""
    return product(a.T, inverse(product(a, a.T)))
