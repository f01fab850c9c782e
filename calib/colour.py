"""Residuals that are not white: how much surer a covariance pretends to be than the data allow."""

from __future__ import annotations

import numpy as np
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
    columns = residual[:, None] if residual.ndim == 1 else residual
    columns = columns - np.ones(len(columns)) @ columns / len(columns)
    variance = float((columns**2).mean())
    worst = 1.0
    for blocks in BLOCKS:
        length = len(columns) // blocks
        if length < LEAST_BLOCK or variance == 0.0:
            continue
        means = columns[: blocks * length].reshape(blocks, length, -1).mean(axis=1)
        ratio = length * float((means**2).mean()) / variance
        if ratio > 1.0 + CHANCE * np.sqrt(2.0 / means.size):
            worst = max(worst, ratio)
    return worst


def residual_of(fit: Calibration, recording: Recording, reference: Reference, *, vector: bool) -> Array:
    """What the fit leaves, in order of time: |h| - F (n,), or with known attitude h - R_wb^T F (n, 3), nT."""
    order = np.argsort(recording.time_s, kind="stable")
    field_nT = fit.apply(recording)[order]
    if not vector:
        return np.asarray(np.sqrt(np.einsum("ni,ni->n", field_nT, field_nT)) - reference.strength_nT)
    assert recording.att_q is not None
    assert reference.field_enu_nT is not None
    return field_nT - world_to_body(recording.att_q[order], np.array(reference.field_enu_nT))
