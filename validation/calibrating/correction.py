"""Correction of a recording's field, or of a scalar magnetometer's strength, by a calibration."""

from __future__ import annotations

import numpy as np

from calib import Calibration
from calib.external import checked
from calib.models.scalar_terms import CHANNEL, HIGH, LOW, STRENGTH, compensated
from recordings import Recording
from scenarios.arrays import Array
from scenarios.errors import InputError


def corrected(calibration: Calibration, recording: Recording, where: str) -> Array:
    """Return what a calibration corrects: the field (n, 3), or the scalar magnetometer's strength (n,), nT.

    Raises InputError as `corrected_field` and `corrected_strength`.
    """
    correct = corrected_strength if calibration.corrects_scalar else corrected_field
    return correct(calibration, recording, where)


def corrected_strength(calibration: Calibration, recording: Recording, where: str) -> Array:
    """Return the scalar magnetometer's strength (n,), nT, without the vehicle's field.

    where : named in error messages. Raises InputError for a fit without terms, and a recording without the channel.
    """
    missing = [name for name in (STRENGTH, LOW, HIGH) if name not in calibration.parameters]
    if calibration.status.kind != "ok":
        raise InputError(f"gave no calibration: {calibration.status.reason}", where=where)
    if missing:
        raise InputError(f"lacks the parameters {', '.join(missing)}", where=where, do="calibrate again")
    if CHANNEL not in recording.channels:
        do = f"record it as {CHANNEL}"
        raise InputError("corrects a scalar magnetometer, and the recording has none", where=where, do=do)
    return compensated(calibration, recording)


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
