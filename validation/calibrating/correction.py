"""Correction of a recording by a calibration."""

from __future__ import annotations

import numpy as np

from calib import Calibration
from calib.external import checked
from recordings import Recording
from scenarios.arrays import Array
from scenarios.errors import InputError


def corrected_field(calibration: Calibration, recording: Recording, where: str) -> Array:
    """Return the corrected field A (m - b), (n, 3), nT, body frame.

    where : named in error messages. Raises InputError for a calibration without an estimate, for a singular matrix,
    and where an eddy-current model has no inverse at a rate of the recording.
    """
    if not calibration.has_estimate:
        raise InputError(f"gave no calibration: {calibration.status.reason}", where=where)
    checked(calibration, where, "use another calibration")
    try:
        with np.errstate(all="ignore"):  # non-finite rows are reported together below
            field_nT = calibration.apply(recording)
    except (np.linalg.LinAlgError, ArithmeticError):
        field_nT = np.full((len(recording), 3), np.nan)
    wrong = ~np.isfinite(field_nT).all(axis=1)
    if wrong.any():
        what = f"corrects row {int(np.argmax(wrong)) + 1} to no finite field ({np.count_nonzero(wrong)} rows in all)"
        do = "use another calibration, or leave these rows out"
        raise InputError(what, where=where, do=do)
    return field_nT
