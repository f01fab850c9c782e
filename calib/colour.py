"""Residuals that are not white: how much surer a covariance pretends to be than the data allow."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from calib.rates import world_to_body
from calib.reference import Reference
from calib.result import Calibration
from sim.dataset import Recording

Array = NDArray[np.float64]
BLOCKS = (20, 50, 200)
"""Numbers of blocks that a recording is cut into: slow structure shows in the means of few, faster in those of many."""
LEAST_BLOCK = 10
CHANCE = 4.0
"""Excess of a block mean's variance, in its standard deviations under white noise, that is taken for colour."""


def inflation(residual: Array) -> float:
    """Factor V >= 1 by which a covariance claimed for white residuals (n,) or (n, k), in order of time, is too small.

    V = max over block lengths L of W_L = L var(block means) / var(residual), which is 1 for white noise; a W_L within
    CHANCE standard deviations (sqrt(2 / blocks / k)) of 1 counts as 1.
    """
    n = len(residual)
    columns = np.ascontiguousarray(residual).reshape(n, -1)
    worst, variance = 1.0, float(block_mean_square(columns, n))
    for blocks in BLOCKS:
        if n // blocks < LEAST_BLOCK or variance == 0.0:
            continue
        ratio = n // blocks * float(block_mean_square(columns, blocks)) / variance
        if ratio > 1.0 + CHANCE * np.sqrt(2.0 / (blocks * columns.shape[1])):
            worst = max(worst, ratio)
    return worst


@njit(cache=True, fastmath={"reassoc", "contract"})
def block_mean_square(columns: Array, blocks: int) -> float:
    """Mean square, about the mean of all, of the means over equally long blocks of columns (n, k); blocks <= n."""
    n, k = columns.shape
    length, total = n // blocks, 0.0
    for j in range(k):
        middle = 0.0
        for i in range(n):
            middle += columns[i, j]
        middle /= n
        for first in range(0, blocks * length, length):
            mean = 0.0
            for i in range(first, first + length):
                mean += columns[i, j]
            total += (mean / length - middle) ** 2
    return float(total / (blocks * k))


def residual_of(fit: Calibration, recording: Recording, reference: Reference, *, vector: bool) -> Array:
    """What the fit leaves, in order of time: |h| - F (n,), or with known attitude h - R_wb^T F (n, 3), nT."""
    field_nT = fit.apply(recording)
    if vector:
        assert recording.att_q is not None
        assert reference.field_enu_nT is not None
        residual = field_nT - world_to_body(recording.att_q, np.array(reference.field_enu_nT))
    else:
        residual = np.sqrt(np.einsum("ni,ni->n", field_nT, field_nT)) - reference.strength_nT
    late = recording.time_s[1:] < recording.time_s[:-1]
    return np.asarray(residual[np.argsort(recording.time_s, kind="stable")] if late.any() else residual)
