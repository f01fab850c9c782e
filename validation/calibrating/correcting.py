"""Correcting a recording with a calibration that can be used on it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from calib import Calibration
from scenarios.errors import InputError
from sim.dataset import Recording

Array = NDArray[np.float64]
MAX_CONDITION, MAX_OFFSET_NT = 1e6, 1e9
"""No magnetometer's calibration is near these: such a matrix flattens the field, such an offset is a tesla."""


def corrected(calibration: Calibration, recording: Recording, where: str) -> Array:
    """The corrected field (n, 3), nT, body frame.

    Raises InputError, about `where`, for a calibration without an estimate, for one with a singular matrix, and where
    it has no inverse at one of the recording's rates.
    """
    _check_usable(calibration, where)
    try:
        with np.errstate(all="ignore"):  # what comes of it is looked at as a whole
            field_nT = calibration.apply(recording)
    except (np.linalg.LinAlgError, ArithmeticError):
        field_nT = np.full((len(recording), 3), np.nan)
    wrong = ~np.isfinite(field_nT).all(axis=1)
    if wrong.any():
        what = f"corrects row {int(np.argmax(wrong)) + 1} to no finite field ({np.count_nonzero(wrong)} rows in all)"
        do = "use another calibration, or leave out the rows that it cannot be used on"
        raise InputError(what, where=where, do=do)
    return field_nT


def _check_usable(calibration: Calibration, where: str) -> None:
    if calibration.status.kind in ("not_applicable", "not_converged"):
        raise InputError(f"gave no calibration: {calibration.status.reason}", where=where)
    matrices = np.stack([calibration.matrix, *(part.matrix for part in calibration.segments)])
    offsets_nT = np.stack([calibration.offset_nT, *(part.offset_nT for part in calibration.segments)])
    finite = np.isfinite(matrices).all() and np.isfinite(offsets_nT).all()
    if not finite or np.linalg.cond(matrices).max() > MAX_CONDITION or np.abs(offsets_nT).max() > MAX_OFFSET_NT:
        what = "is no calibration: its matrix is singular, or its offset a tesla"
        raise InputError(what, where=where, do="use another calibration")
