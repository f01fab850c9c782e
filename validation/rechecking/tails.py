"""Tests and intervals of an estimate whose covariance is one of several, weighted."""

from __future__ import annotations

import numpy as np
from scipy.special import chndtr, gammaincc, ndtr, ndtri
from scipy.stats import chi2

from scenarios.arrays import Array

ROUNDING = 1e-10
"""Eigenvalue of a scaled covariance below which a direction is a sum that is zero, as of the diagonal of soft iron."""
HALVINGS = 40
"""Halvings of an interval that holds a quantile: to rounding."""


def chance_of(value: Array, spreads: Array, weights: Array, freedom: int) -> float:
    """Return the chance of as large an estimate of zeros: Wald's test, chi squared, over covariances (k, m, m)."""
    size = np.sqrt(np.einsum("kmm->km", spreads)).clip(np.finfo(float).tiny)
    scaled = spreads / (size[:, :, None] * size[:, None, :])
    inverse = np.linalg.pinv(scaled, rcond=ROUNDING, hermitian=True)
    z = value / size
    squares = np.einsum("km,kmn,kn->k", z, inverse, z)
    return float(weights @ gammaincc(freedom / 2.0, squares.clip(0.0) / 2.0))


def reach(chance: float, stds: Array, weights: Array) -> Array:
    """Return x (q,) that a normal error, of standard deviations (k, q) with weights (k,), exceeds with this chance."""
    low, high = np.zeros(stds.shape[1]), -ndtri(chance) * stds.max(axis=0)
    least = stds.clip(np.finfo(float).tiny)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        over = weights @ ndtr(-middle / least) > chance
        low, high = np.where(over, middle, low), np.where(over, high, middle)
    return np.asarray(high)


def size_found(variances: Array, weights: Array, limit: float, power: float, freedom: int) -> float:
    """Return the size of a change that a test at the chance `limit` finds with this power.

    variances (k,) : of the estimate along the change; the test is that of `chance_of`. The power is that over the
    models of the noise, weighted.
    """
    low, high = 0.0, float(np.sqrt(chi2.isf(limit, freedom) * variances.max()))
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        over = weights @ gammaincc(freedom / 2.0, middle**2 / variances / 2.0) > limit
        low, high = (middle, high) if over else (low, middle)
    reached, low, high = high, high, high + 6.0 * float(np.sqrt(variances.max()))
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        found = weights @ (1.0 - chndtr(reached**2 / variances, freedom, middle**2 / variances))
        low, high = (middle, high) if found < power else (low, middle)
    return high
