"""The magnetometers of a telemetry log, with ArduPilot's calibration undone where the log has the parameters."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from recordings.body_frame import flu_from_frd
from recordings.readers.ardupilot.compass import (
    MILLIGAUSS_NT,
    calibration_names,
    compass_calibration,
    compass_of,
    own_parameters,
    suffix,
)
from recordings.readers.ardupilot.magnetometers import Compass, told_undone
from recordings.readers.tlog.frames import Frames
from recordings.readers.tlog.quantities import battery_current, throttle_stream
from recordings.readers.tlog.telemetry import Telemetry
from recordings.readers.vehicle_log import vector_columns
from recordings.streams import Stream
from scenarios.arrays import Array

MAG = ("xmag", "ymag", "zmag")
MAGNETOMETERS = (("RAW_IMU", "SCALED_IMU", "HIGHRES_IMU"), ("SCALED_IMU2",), ("SCALED_IMU3",))
"""The messages of the first, second and third magnetometer."""
GAUSS = ("HIGHRES_IMU",)
"""Messages that give the field in gauss, the others in milligauss, cut to whole numbers."""
DRIVE: dict[float, Callable[[Telemetry], Stream | None]] = {1.0: throttle_stream, 2.0: battery_current}
"""COMPASS_MOTCT -> what the motors' term follows: the throttle (0 to 1) or the battery's current (A)."""


def magnetometers_in(log: Telemetry) -> dict[int, Frames]:
    """Return the messages of each magnetometer by its place from 0: those that are most, where there are several."""
    found: dict[int, Frames] = {}
    for place, names in enumerate(MAGNETOMETERS):
        rows = [log.types[name] for name in names if name in log.types and log.types[name].vector(*MAG).any()]
        found |= {place: max(rows, key=len)} if rows else {}
    return found


def compasses_of(log: Telemetry) -> dict[str, Compass]:
    """Return the magnetometers by their number, the first in use first."""
    found = magnetometers_in(log)
    numbers = {place: compass_of(log.parameters, place) for place in found}
    unused = {place: not log.parameters.get(f"COMPASS_USE{suffix(numbers[place])}", 1.0) for place in found}
    ordered = sorted(found, key=lambda place: (unused[place], place))
    return {str(place + 1): _compass(log, found[place], numbers[place]) for place in ordered}


def _compass(log: Telemetry, rows: Frames, number: int) -> Compass:
    field_mG, at_s, parameters = _field_mG(rows), log.times_s(rows), log.parameters
    if any(name in parameters for name in calibration_names(number)):
        motor_mG = _motor_term(log, number, at_s)
        calibration = compass_calibration(parameters, number)
        field_mG = calibration.raw_mG(field_mG, motor_mG)
        applied = calibration.applied(own_parameters(parameters, number))
        note = told_undone(parameters.last, number, bool(motor_mG.any()))
    else:
        applied, note = None, f"{rows.name}: the log has no parameters of the compass, nothing can be undone"
    columns = vector_columns("mag", flu_from_frd(field_mG) * MILLIGAUSS_NT)
    return Compass(Stream(at_s, columns), applied, (note,))


def _field_mG(rows: Frames) -> Array:
    """Return the field (n, 3) in mG, cut numbers in the middle of what was cut."""
    values = rows.vector(*MAG)
    return 1000 * values if rows.name in GAUSS else values + np.sign(values) / 2


def _motor_term(log: Telemetry, number: int, at_s: Array) -> Array:
    """Return k p, mG (n, 3): COMPASS_MOT times the throttle or the current, as COMPASS_MOTCT says."""
    gain = log.parameters.vector(f"COMPASS_MOT{suffix(number)}")
    drive = DRIVE.get(log.parameters.get("COMPASS_MOTCT"))
    stream = drive(log) if drive and gain.any() else None
    if stream is None:
        return np.zeros((len(at_s), 3))
    (values,) = stream.columns.values()
    order = np.argsort(stream.times_s)
    return np.asarray(np.interp(at_s, stream.times_s[order], values[order])[:, None] * gain)
