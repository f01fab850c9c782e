"""Attitude, position, rates and specific force of a DataFlash log, in FLU and ENU."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from recordings.body_frame import enu_from_ned, flu_from_frd
from recordings.channels import TEMPERATURE
from recordings.columns import ATTITUDE
from recordings.readers.ardupilot.messages import Dataflash, Messages
from recordings.readers.ardupilot.parameters import Parameters
from recordings.readers.vehicle_log import vector_columns
from recordings.streams import Interpolation, Stream
from scenarios.arrays import Array

QUATERNION, EULER = ("Q1", "Q2", "Q3", "Q4"), ("Roll", "Pitch", "Yaw")
ATTITUDES = ("XKQ", "XKQ1", "NKQ", "NKQ1", "ATT", "AHR2")
"""The messages of attitude, best first: the filters' quaternions of the autopilot's body, then the vehicle's angles."""
OF_VEHICLE = ("ATT", "AHR2")
"""Attitudes of the vehicle's body, which AHRS_TRIM turns from the autopilot's body, where the compass is."""
FEWEST = 0.5
"""Share of the rows of the most frequent attitude from which a better attitude is taken."""
POSITIONS = ("XKF1", "NKF1", "EKF1", "NTUN")
NED = ("PN", "PE", "PD")
PRIMARY = {"X": "XKF4", "N": "NKF4"}
"""By a filter's first letter, the message whose PI is the core in use."""
UNIT_NORM = 0.1
"""A quaternion whose norm is farther from 1 is damaged."""
RATE, FORCE = ("GyrX", "GyrY", "GyrZ"), ("AccX", "AccY", "AccZ")
IMU_TEMPERATURE = ("T", "Temp")
CENTIDEGREE = 0.01
"""Degrees of a count, where a log gives whole numbers in place of the format's hundredths."""
COMPASS_AS_YAW = (1.0, 3.0)
"""EK3_SRC1_YAW: 1 the compass, 3 satellites with the compass in reserve."""


def imu_stream(log: Dataflash) -> dict[str, Stream]:
    """Return rates and specific force of the first inertial unit, and its temperature or else the barometer's."""
    found = log.instances("IMU")
    rows = found[min(found)] if found else None
    if rows is None or not all(name in rows for name in RATE + FORCE):
        return {}
    columns = vector_columns("gyro", flu_from_frd(rows.vector(*RATE)))
    columns |= vector_columns("accel", flu_from_frd(rows.vector(*FORCE)))
    warm = next((name for name in IMU_TEMPERATURE if name in rows), None)
    measured = bool(warm and rows.numbers(warm).any())
    columns |= {TEMPERATURE: rows.numbers(warm)} if warm and measured else {}
    unit = {"inertial unit": Stream(log.times_s(rows), columns)}
    return unit if measured else unit | _barometer(log)


def _barometer(log: Dataflash) -> dict[str, Stream]:
    """Return the temperature of the first barometer, where the inertial unit gives none."""
    found = log.instances("BARO")
    rows = found[min(found)] if found else None
    if rows is None or "Temp" not in rows or not rows.numbers("Temp").any():
        return {}
    return {"barometer": Stream(log.times_s(rows), {TEMPERATURE: rows.numbers("Temp")})}


def attitude_stream(log: Dataflash, parameters: Parameters) -> tuple[dict[str, Stream], list[str]]:
    """Return the attitude, body to world, of the best message that is frequent, and notes."""
    candidates = {name: rows for name in ATTITUDES if (rows := primary(log, name)) and _has_attitude(rows)}
    most = max(map(len, candidates.values()), default=0)
    name = next((name for name, rows in candidates.items() if len(rows) >= FEWEST * most), None)
    if name is None:
        return {}, []
    rows = candidates[name]
    q = rows.vector(*QUATERNION) if all(part in rows for part in QUATERNION) else quaternion_of(_angles_deg(rows))
    if name in OF_VEHICLE:
        q = without_trim(q, parameters)
    columns = vector_columns("attitude", enu_from_ned(unit_quaternions(q)))
    stream = Stream(log.times_s(rows), columns, dict.fromkeys(ATTITUDE, Interpolation.SLERP))
    return {"attitude": stream}, [f"attitude: {name}", *yaw_note(parameters)]


def _angles_deg(rows: Messages) -> Array:
    """Return roll, pitch and yaw in degrees (n, 3): whole numbers count centidegrees."""
    return rows.vector(*EULER) * [CENTIDEGREE if rows.whole(name) else 1.0 for name in EULER]


def _has_attitude(rows: Messages) -> bool:
    return any(all(part in rows for part in parts) for parts in (QUATERNION, EULER))


def position_stream(log: Dataflash) -> dict[str, Stream]:
    """Return the filter's position east, north, up of its origin, m."""
    name = next((name for name in POSITIONS if (rows := primary(log, name)) and all(n in rows for n in NED)), None)
    rows = primary(log, name) if name else None
    if rows is None:
        return {}
    north, east, down = rows.vector(*NED).T
    return {"position": Stream(log.times_s(rows), vector_columns("position", np.column_stack([east, north, -down])))}


def primary(log: Dataflash, name: str) -> Messages | None:
    """Return the messages of a filter's core in use, by the majority of the log; None where there are none."""
    found = log.types[name].instances() if name in log.types else {}
    choice = log.types.get(PRIMARY.get(name[0], ""))
    if choice is not None and "PI" in choice and len(found) > 1:
        numbers, counts = np.unique(choice.numbers("PI"), return_counts=True)
        core = int(numbers[np.argmax(counts)])
        return found.get(core, found[min(found)])
    return found[min(found)] if found else None


def quaternion_of(angles_deg: Array) -> Array:
    """Return quaternions w x y z (n, 4) of roll, pitch and yaw (n, 3) in degrees: q = q_z(yaw) q_y(pitch) q_x(roll)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(np.radians(angles_deg) / 2).T, np.sin(np.radians(angles_deg) / 2).T
    w, x = cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy
    y, z = cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy
    return np.column_stack([w, x, y, z])


def without_trim(q: Array, parameters: Parameters) -> Array:
    """Return the attitude (n, 4) of the autopilot's body: R_autopilot = R_vehicle T, T of AHRS_TRIM_X and _Y in rad."""
    roll, pitch = (np.degrees(parameters.get(f"AHRS_TRIM_{axis}")) for axis in "XY")
    w, x, y, z = quaternion_of(np.array([[roll, pitch, 0.0]]))[0]
    right = np.array([[w, -x, -y, -z], [x, w, z, -y], [y, -z, w, x], [z, y, -x, w]])  # q times the trim
    return np.asarray(q @ right.T)


def unit_quaternions(q: Array) -> Array:
    """Return quaternions (n, 4) of norm 1, NaN where the norm is not near 1."""
    norm = np.linalg.norm(q, axis=1)
    return np.where(np.abs(norm - 1) < UNIT_NORM, 1 / np.where(norm > 0, norm, np.nan), np.nan)[:, None] * q


def yaw_note(parameters: Parameters) -> Iterable[str]:
    """Yield the line about a heading that comes from the compasses themselves."""
    if parameters.get("EK3_SRC1_YAW", 1.0) in COMPASS_AS_YAW and parameters.get("COMPASS_USE", 1.0):
        yield "the attitude's heading comes from the compasses: a fit against the attitude repeats their heading error"
