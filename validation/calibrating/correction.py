"""Correcting a recording with a calibration that can be used on it."""

from __future__ import annotations

import numpy as np

from calib import Calibration
from calib.outside import checked
from recordings import Recording
from scenarios.arrays import Array
from scenarios.errors import InputError


def corrected_field(calibration: Calibration, recording: Recording, where: str) -> Array:
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
    checked(calibration, where, "use another calibration")
