"""The magnetometers of a telemetry log, with the autopilot's calibration undone where the log has the parameters."""

from __future__ import annotations

import numpy as np

from recordings.body_frame import flu_from_frd
from recordings.readers.ardupilot.compass import (
    MILLIGAUSS_NT,
    calibration_names,
    compass_calibration,
    compass_of,
    own_parameters,
)
from recordings.readers.ardupilot.in_force import AppliedInLog
from recordings.readers.ardupilot.magnetometers import Compass, is_used, told_undone
from recordings.readers.ardupilot.motor_term import motors_come_first
from recordings.readers.tlog.frames import Frames
from recordings.readers.tlog.px4_field import px4_compass
from recordings.readers.tlog.quantities import drive_of
from recordings.readers.tlog.telemetry import Telemetry
from recordings.readers.vehicle_log import vector_columns
from recordings.streams import Stream
from scenarios.arrays import Array

MAG = ("xmag", "ymag", "zmag")
MAGNETOMETERS = (("HIGHRES_IMU", "RAW_IMU", "SCALED_IMU"), ("SCALED_IMU2",), ("SCALED_IMU3",))
"""The messages of the first, second and third magnetometer, the finest first."""
FINE_SHARE = 0.5
"""Share of the most frequent message's rows from which a finer message is taken."""
GAUSS = ("HIGHRES_IMU",)
"""Messages that give the field in gauss, the others in milligauss, cut to whole numbers."""


def magnetometers_in(log: Telemetry) -> dict[int, Frames]:
    """Return the messages of each magnetometer by its place from 0: the finest that is frequent."""
    found: dict[int, Frames] = {}
    for place, names in enumerate(MAGNETOMETERS):
        rows = [log.types[name] for name in names if name in log.types and log.types[name].vector(*MAG).any()]
        most = max(map(len, rows), default=0)
        finest = next((one for one in rows if len(one) >= FINE_SHARE * most), None)
        found |= {place: finest} if finest is not None else {}
    return found


def compasses_of(log: Telemetry) -> dict[str, Compass]:
    """Return the magnetometers by their number, the first in use first."""
    found = magnetometers_in(log)
    if not log.of_ardupilot and log.parameters.last:
        return {str(place + 1): px4_compass(log, rows, _field_mG(rows)) for place, rows in found.items()}
    ordered = sorted(found, key=lambda place: (not is_used(log.parameters, place), place))
    return {str(place + 1): _compass(log, found[place], compass_of(log.parameters, place)) for place in ordered}


def _compass(log: Telemetry, rows: Frames, number: int) -> Compass:
    rows = rows.where(np.asarray(np.isfinite(rows.vector(*MAG)).all(axis=1)))
    field_mG, at_s, parameters = _field_mG(rows), log.times_s(rows), log.parameters
    if any(name in parameters for name in calibration_names(number)):
        field_mG, notes = _undone(log, number, at_s, field_mG)
        applied = compass_calibration(parameters, number).applied(own_parameters(parameters, number))
    else:
        applied, notes = None, [f"{rows.name}: the log has no parameters of the compass, nothing can be undone"]
    columns = vector_columns("mag", flu_from_frd(field_mG) * MILLIGAUSS_NT)
    return Compass(Stream(at_s, columns), applied, tuple(notes))


def _undone(log: Telemetry, number: int, at_s: Array, field_mG: Array) -> tuple[Array, list[str]]:
    """Return the field before ArduPilot's calibration, mG (n, 3), and notes."""
    first = motors_come_first(log.parameters, *log.firmware, old_names=False)
    applied = AppliedInLog(log.parameters, number, at_s, motors_first=first)
    motor_mG, lacking = applied.motor_term(drive_of(log))
    raw_mG, _ = applied.undone(field_mG, motor_mG)
    told = told_undone(log.parameters.last, number, "the motors' term" if motor_mG.any() else "")
    return raw_mG, [told, *applied.notes, *([lacking] if lacking else [])]


def _field_mG(rows: Frames) -> Array:
    """Return the field (n, 3) in mG, cut numbers in the middle of what was cut."""
    values = rows.vector(*MAG)
    return 1000 * values if rows.name in GAUSS else values + np.sign(values) / 2
