"""Covariance of a change with that of the old calibration."""

from __future__ import annotations

import numpy as np

from calib import Calibration
from calib.models.vector import SOFT_IRON_NAMES
from calib.result import OFFSET_NAMES
from scenarios.arrays import Array
from validation.rechecking.change import ChangeEstimate
from validation.rechecking.noise import WeightedCovariances

AXES = "xyz"


def with_old(old: Calibration, estimate: ChangeEstimate) -> WeightedCovariances:
    """Return the covariances of the change with the old calibration's; of one without a claim the estimate's own.

    d = -A db,  E = -A dS, of which the strength sees the symmetric half. The old claim is enlarged as the same
    calibrator's claim on the new log has to be: the noise of one instrument.
    """
    if old.covariance is None:
        return estimate.spread
    moved = np.array([_moved(name, old.matrix, estimate) for name in old.covariance_names])
    own = moved.T @ old.covariance @ moved
    whole = estimate.spread.covariances + estimate.shortfall[:, None, None] * own
    return WeightedCovariances(estimate.spread.weights, whole)


def _moved(name: str, A: Array, estimate: ChangeEstimate) -> Array:
    """Return d values / d a parameter of the old calibration (p,)."""
    found = np.zeros(len(estimate.values))
    if name in OFFSET_NAMES:
        found[:3] = -A[:, OFFSET_NAMES.index(name)]
        return found
    dS = np.zeros((3, 3))
    if name == "scale":
        dS = np.eye(3)
    elif name in SOFT_IRON_NAMES:
        i, j = AXES.index(name[2]), AXES.index(name[3])
        dS[i, j] = 1.0
    E = -A @ dS * estimate.strength_nT
    if estimate.entries == 9:
        found[3:12] = E.ravel()
    else:
        found[3:9] = ((E + E.T) / 2)[np.triu_indices(3)]
    return found
