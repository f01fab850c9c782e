"""The reference field of a recording: stated by the user, or read from a simulated run's file."""

from __future__ import annotations

import datetime
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from calib import Reference
from recordings import Recording, read_recording
from recordings.applied import AppliedCalibration
from recordings.checks import FIELD_RANGE_NT
from recordings.manifest import file_of
from recordings.reader import parameters_of
from recordings.reading import Reading, report
from recordings.recording import Origin
from recordings.units import likely_unit
from scenarios.arrays import Array
from scenarios.errors import InputError, errors_relocated
from validation.policy import POLICY
from validation.text import figure


def recording_and_reference(
    path: Path,
    *,
    run: int = 0,
    reading: Reading | None = None,
    strength_nT: float | None = None,
    enu: Sequence[float] | None = None,
) -> tuple[Recording, Reference]:
    """Read a run, a dataset's run or a measured log, and the reference field of the recording.

    Raises InputError for an unusable file and for an unknown reference; see `reference_of`.
    """
    file = file_of(path, run)
    recording = read_recording(file, reading=reading)
    return recording, reference_of(file, *told_field(strength_nT, enu, recording.origin, recording.mag_nT))


def reference_of(file: Path, strength_nT: float | None, enu: Sequence[float] | None, otherwise: str = "") -> Reference:
    """Return the stated reference, else the field in the metadata of a simulated run's file.

    otherwise : a further remedy for the error message. Raises InputError where neither is known.
    """
    if strength_nT is None and enu is None:
        known = parameters_of(file).get("field_enu_nT")
        if known is None:
            raise _unknown_field(str(file), otherwise)
        return stated_reference(str(file), None, known, f"{file}: field_enu_nT of its metadata")
    return stated_reference(str(file), strength_nT, enu)


def field_at(place: Sequence[float] | None, date: datetime.date | None) -> list[float] | None:
    """Return the world model's field (east, north, up) at a place and date, nT; None where neither is stated.

    place : latitude and longitude in degrees, altitude in m or nothing for sea level. Raises InputError for one without
    the other, and for a date outside the model's life.
    """
    from scenarios.spec import FieldSpec
    from sim.field import earth_field_enu_nT

    if place is None and date is None:
        return None
    if place is None or date is None:
        given, missing = ("--date", "--place") if place is None else ("--place", "--date")
        raise InputError(f"needs {missing} beside it", where=given, do="the field changes with both")
    names = dict(zip(("latitude_deg", "longitude_deg", "altitude_m"), place, strict=False))
    with errors_relocated("--date", "field.date"):
        return [float(part) for part in earth_field_enu_nT(FieldSpec(**names, date=date))]


def told_field(
    strength_nT: float | None, enu: Sequence[float] | None, origin: Origin | None, mag_nT: Array | None = None
) -> tuple[float | None, Sequence[float] | None]:
    """Return the stated strength and vector, else the world model's vector at the place and date of a log.

    mag_nT : the log's field (n, 3); without a place, the strength is the median with the calibration in force.
    Raises InputError for a log that tells its place without a date.
    """
    if strength_nT is not None or enu is not None or origin is None:
        return strength_nT, enu
    if origin.place is None:
        return None if mag_nT is None else strength_in_force(origin.applied, mag_nT), None
    if origin.date is None:
        raise InputError("tells its place and no date", where="the log", do="give --date YYYY-MM-DD")
    return None, field_at(origin.place, origin.date)


def strength_in_force(applied: AppliedCalibration | None, mag_nT: Array) -> float | None:
    """Return the median strength (n, 3), nT, with the calibration that the autopilot had in force, and tell it.

    None where no calibration was in force, or where the strength is none of the Earth's field.
    """
    if applied is None or not (np.any(applied.offset_nT) or np.any(applied.matrix != np.eye(3))):
        return None
    corrected = (mag_nT - applied.offset_nT) @ np.asarray(applied.matrix).T
    strength_nT = float(np.nanmedian(np.linalg.norm(corrected, axis=1)))
    low, high = POLICY.earth_nT
    if not low <= strength_nT <= high:
        return None
    how = "the median with the calibration in force, as the log tells no place"
    report(f"field strength taken as {figure(strength_nT)} nT: {how} (--field-strength-nT states it)")
    return strength_nT


def stated_reference(
    where: str, strength_nT: float | None, enu: Sequence[float] | None, enu_from: str = "--field-enu-nT"
) -> Reference:
    """Return the reference of a strength, of a vector (east, north, up), or of both, nT; InputError for neither."""
    if strength_nT is not None:
        _check_strength(strength_nT, "--field-strength-nT")
        if enu is None:
            return Reference(strength_nT)
    if enu is None:
        raise _unknown_field(where)
    if len(enu) != 3:
        raise InputError(f"{enu!r} is not a field vector", where=enu_from, do="give east, north and up in nT")
    _check_strength(math.hypot(*enu), enu_from)
    strength = float(np.linalg.norm(enu)) if strength_nT is None else strength_nT
    return Reference(strength, (enu[0], enu[1], enu[2]))


def _unknown_field(where: str, otherwise: str = "") -> InputError:
    do = f"give --field-strength-nT F or --field-enu-nT E,N,U{otherwise}"
    return InputError("the field at this place is not known", where=where, do=do)


def _check_strength(strength_nT: float, where: str) -> None:
    """Raise InputError outside FIELD_RANGE_NT: a strength in uT would scale every result by a thousand."""
    low, high = FIELD_RANGE_NT
    if not low <= strength_nT <= high:
        unit = likely_unit(strength_nT)
        guess = f": it looks like {unit}" if unit else ""
        what = f"a field of {strength_nT:g} nT is not between {low:.0f} and {high:.0f} nT{guess}"
        raise InputError(what, where=where, do="give it in nT")
