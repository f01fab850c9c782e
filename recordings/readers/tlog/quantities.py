"""Attitude, motion, power, commands, states and place of a telemetry log, under a recording's names."""

from __future__ import annotations

import math

import numpy as np

from recordings.body_frame import enu_from_ned, flu_from_frd
from recordings.channels import (
    ALTITUDE,
    ARMED,
    BATTERY_VOLTAGE,
    LATITUDE,
    LONGITUDE,
    TEMPERATURE,
    THROTTLE,
    current_name,
    motor_output_name,
)
from recordings.columns import ATTITUDE
from recordings.readers.ardupilot.motion import quaternion_of, unit_quaternions, without_trim
from recordings.readers.ardupilot.motor_term import MOTORS as QUAD_MOTORS
from recordings.readers.ardupilot.motor_term import Drive
from recordings.readers.ardupilot.power import motor_outputs
from recordings.readers.ardupilot.vehicle import mode_name
from recordings.readers.tlog.frames import Frames
from recordings.readers.tlog.telemetry import Telemetry
from recordings.readers.vehicle_log import Columns, vector_columns
from recordings.streams import Interpolation, Stream
from scenarios.arrays import Array

STANDARD_GRAVITY = 9.80665
"""m/s2 of 1000 mG of specific force."""
RATE, FORCE = ("xgyro", "ygyro", "zgyro"), ("xacc", "yacc", "zacc")
IMUS = {
    "HIGHRES_IMU": (1.0, 1.0),
    "RAW_IMU": (1e-3, STANDARD_GRAVITY * 1e-3),
    "SCALED_IMU": (1e-3, STANDARD_GRAVITY * 1e-3),
}
"""Messages of the inertial unit, with rad/s and m/s2 of a count."""
QUATERNION, EULER = ("q1", "q2", "q3", "q4"), ("roll", "pitch", "yaw")
NO_CURRENT, NO_VOLTAGE = -1.0, 65_535.0
"""Values of SYS_STATUS for a current and a voltage that are not measured."""
CENTIAMPERE, MILLIVOLT, CENTIDEGREE, DEGREE_E7, MILLIMETRE = 1e-2, 1e-3, 1e-2, 1e-7, 1e-3
MOTORS = {"ESC_TELEMETRY_1_TO_4": 1, "ESC_TELEMETRY_5_TO_8": 5, "ESC_TELEMETRY_9_TO_12": 9}
"""Messages of motor controllers, with the first motor of the four."""
HEARTBEAT_S = 2.0
"""The state of the first heartbeat held so long before it: heartbeats come each second."""
THREE_D_FIX = 3
ARMED_FLAG = 128
"""HEARTBEAT.base_mode of an armed vehicle."""


def streams_of(log: Telemetry) -> tuple[dict[str, Stream], list[str]]:
    """Return the streams of all quantities that a recording has names for, and notes."""
    currents, notes = _currents(log)
    attitude = _attitude(log)
    found = {**_inertial(log), **attitude, **_position(log), **currents}
    found |= _power(log) | _outputs(log) | _states(log) | _fixes(log)
    about = ["the attitude's heading may come from the compass: a fit against the attitude repeats its heading error"]
    return found, [*(about if attitude else []), *notes]


def _inertial(log: Telemetry) -> dict[str, Stream]:
    """Return rate, specific force and temperature of the first inertial unit, by the most frequent message."""
    names = [name for name in IMUS if name in log.types and log.types[name].vector(*FORCE).any()]
    if not names:
        return {}
    rows = max((log.types[name] for name in names), key=len)
    rate, force = IMUS[rows.name]
    columns = vector_columns("gyro", flu_from_frd(rows.vector(*RATE) * rate))
    columns |= vector_columns("accel", flu_from_frd(rows.vector(*FORCE) * force))
    if "temperature" in rows and rows.numbers("temperature").any():
        columns[TEMPERATURE] = rows.numbers("temperature") * (1.0 if rows.name == "HIGHRES_IMU" else CENTIDEGREE)
    return {"inertial unit": Stream(log.times_s(rows), columns)}


def _attitude(log: Telemetry) -> dict[str, Stream]:
    """Return the attitude, body to world, by the quaternion or, where angles come twice as often, by the angles."""
    quaternions, angles = log.get("ATTITUDE_QUATERNION"), log.get("ATTITUDE")
    if quaternions is not None and 2 * len(quaternions) >= len(angles or ()):
        rows, q = quaternions, quaternions.vector(*QUATERNION)
    elif angles is not None:
        rows, q = angles, quaternion_of(np.degrees(angles.vector(*EULER)))
    else:
        return {}
    columns = vector_columns("attitude", enu_from_ned(unit_quaternions(without_trim(q, log.parameters))))
    return {"attitude": Stream(log.times_s(rows), columns, dict.fromkeys(ATTITUDE, Interpolation.SLERP))}


def _position(log: Telemetry) -> dict[str, Stream]:
    rows = log.get("LOCAL_POSITION_NED")
    if rows is None:
        return {}
    north, east, down = rows.vector("x", "y", "z").T
    columns = vector_columns("position", np.column_stack([east, north, -down]))
    return {"position": Stream(log.times_s(rows), columns)}


def _currents(log: Telemetry) -> tuple[dict[str, Stream], list[str]]:
    """Return the motors' currents, else the battery's as current 1."""
    found: dict[str, Stream] = {}
    for name in [name for name in MOTORS if name in log.types]:
        for k, current in enumerate((log.types[name].numbers("current") * CENTIAMPERE).T):
            motor = current_name(MOTORS[name] + k)
            found |= {f"{name} {k}": _stream(log, log.types[name], {motor: current})} if current.any() else {}
    if found or (battery := battery_current(log)) is None:
        return found, []
    note = "current_1_A is the battery's current (SYS_STATUS): no motor's own current is logged"
    return {"battery current": battery}, [note]


def battery_current(log: Telemetry) -> Stream | None:
    """Return the battery's current in A, None where it is not measured."""
    rows = log.get("SYS_STATUS")
    measured = rows.where(rows.numbers("current_battery") != NO_CURRENT) if rows is not None else None
    if measured is None or not len(measured) or not np.ptp(measured.numbers("current_battery")):
        return None
    return _stream(log, measured, {current_name(1): measured.numbers("current_battery") * CENTIAMPERE})


def throttle_stream(log: Telemetry) -> Stream | None:
    """Return the throttle from 0 to 1, None where it is not sent."""
    rows = log.get("VFR_HUD")
    return None if rows is None else _stream(log, rows, {THROTTLE: rows.numbers("throttle") / 100})


def _power(log: Telemetry) -> dict[str, Stream]:
    found = {"throttle": throttle_stream(log), "battery voltage": _voltage(log)}
    return {name: stream for name, stream in found.items() if stream is not None}


def _voltage(log: Telemetry) -> Stream | None:
    """Return the battery's voltage, None where it is not sent."""
    rows = log.get("SYS_STATUS")
    if rows is None:
        return None
    rows = rows.where(~np.isin(rows.numbers("voltage_battery"), (0.0, NO_VOLTAGE)))
    return _stream(log, rows, {BATTERY_VOLTAGE: rows.numbers("voltage_battery") * MILLIVOLT})


def drive_of(log: Telemetry) -> Drive:
    """Return what the motors' term of a compass may follow."""
    named = {name: one for one in _outputs(log).values() for name in one.columns}
    outputs = {k: named[name] for k in QUAD_MOTORS if (name := motor_output_name(k)) in named}
    return Drive(throttle_stream(log), battery_current(log), _voltage(log), outputs)


def _outputs(log: Telemetry) -> dict[str, Stream]:
    """Return the motors' outputs from 0 to 1, of ArduPilot, whose parameters tell the motors."""
    rows = log.get("SERVO_OUTPUT_RAW")
    if rows is None or not log.of_ardupilot:
        return {}
    rows = rows.where(rows.numbers("port") == 0)
    pulses_us = {k: rows.numbers(f"servo{k}_raw") for k in range(1, 17)}
    outputs = motor_outputs(pulses_us, log.parameters, log.firmware[0]) if len(rows) else {}
    return {f"output {k}": _stream(log, rows, {motor_output_name(motor): x}) for k, (motor, x) in outputs.items()}


def _states(log: Telemetry) -> dict[str, Stream]:
    """Return the flight modes as phases, and the armed state, each from its heartbeat to the next."""
    rows = log.get("HEARTBEAT")
    if rows is None:
        return {}
    vehicle = log.firmware[0] if log.of_ardupilot else ""
    modes = [mode_name(vehicle, int(mode)) for mode in rows.numbers("custom_mode")]
    armed = (rows.rows["base_mode"] & ARMED_FLAG > 0).astype(np.float64)
    columns: Columns = {"phase": np.array(modes), ARMED: armed}
    at_s = log.times_s(rows)
    before = {name: np.concatenate([values[:1], values]) for name, values in columns.items()}
    held = dict.fromkeys(columns, Interpolation.HELD)
    return {"heartbeat": Stream(np.r_[at_s.min() - HEARTBEAT_S, at_s], before, held, max_gap_intervals=math.inf)}


def fixes_of(log: Telemetry) -> Frames | None:
    """Return the satellites' fixes in three dimensions, None where there are none."""
    rows = log.get("GPS_RAW_INT")
    fixed = (
        rows.where((rows.numbers("fix_type") >= THREE_D_FIX) & rows.vector("lat", "lon").any(axis=1)) if rows else None
    )
    return fixed if fixed is not None and len(fixed) else None


def places_of(fixes: Frames) -> Array:
    """Return latitude and longitude in degrees and altitude in m (n, 3)."""
    return fixes.vector("lat", "lon", "alt") * [DEGREE_E7, DEGREE_E7, MILLIMETRE]


def _fixes(log: Telemetry) -> dict[str, Stream]:
    fixes = fixes_of(log)
    if fixes is None:
        return {}
    return {"fixes": _stream(log, fixes, dict(zip((LATITUDE, LONGITUDE, ALTITUDE), places_of(fixes).T, strict=True)))}


def _stream(log: Telemetry, rows: Frames, columns: dict[str, Array]) -> Stream:
    return Stream(log.times_s(rows), columns)
