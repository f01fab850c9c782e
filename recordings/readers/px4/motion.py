"""How the vehicle moves, of a PX4 log: rate, specific force, attitude, position, temperature, flight mode."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from recordings.body_frame import enu_from_ned, flu_from_frd
from recordings.channels import ALTITUDE, LATITUDE, LONGITUDE, TEMPERATURE
from recordings.columns import ATTITUDE, POSITION
from recordings.readers.px4.contents import ULog, UlogTopic
from recordings.readers.px4.place import fixes, local_enu
from recordings.readers.px4.sampling import sample_times_s
from recordings.readers.vehicle_log import MOST_MISSING, vector_columns
from recordings.streams import Interpolation, Stream
from scenarios.arrays import Array

NOT_SAMPLED = 0x7FFFFFFF
"""A relative time of sensor_combined without a sample."""
MODES = {
    **{0: "manual", 1: "altitude", 2: "position", 3: "mission", 4: "hold", 5: "return", 6: "position slow"},
    **{8: "altitude cruise", 10: "acro", 12: "descend", 13: "termination", 14: "offboard", 15: "stabilized"},
    **{16: "rattitude", 17: "takeoff", 18: "land", 19: "follow", 20: "precision land", 21: "orbit", 22: "vtol takeoff"},
}
"""vehicle_status.nav_state in words."""
MAGNETOMETER_UNUSED = 5
"""EKF2_MAG_TYPE of an attitude without a magnetometer."""
Streams = dict[str, Stream]


def motion_streams(log: ULog, magnetometer: UlogTopic | None) -> tuple[Streams, dict[str, str], set[str]]:
    """Return the streams of motion under a recording's names, notes by column, and the names of the used fields.

    magnetometer : sensor_mag of the sensor that is read, whose temperature comes first.
    """
    streams = _inertial(log) | _phase(log)
    position, note = _position(log)
    streams |= position
    notes = {POSITION[0]: note}
    attitude = log.first("vehicle_attitude")
    if attitude and "q[3]" in attitude:
        q = attitude.vectors("q[0]", "q[1]", "q[2]", "q[3]")
        norm = np.linalg.norm(q, axis=1, keepdims=True)
        unit = np.divide(q, norm, out=np.full_like(q, np.nan), where=norm > 0)
        columns = vector_columns("attitude", enu_from_ned(unit))
        streams["attitude"] = Stream(sample_times_s(attitude), columns, dict.fromkeys(ATTITUDE, Interpolation.SLERP))
        if log.parameters.get("EKF2_MAG_TYPE") != MAGNETOMETER_UNUSED:
            notes[ATTITUDE[0]] = (
                "the attitude's heading comes from the magnetometer: a fit to the attitude repeats its error"
            )
    temperature, thermometer = _temperature(log, magnetometer)
    if magnetometer is None or not thermometer.startswith(magnetometer.name):
        notes[TEMPERATURE] = f"{TEMPERATURE} is {thermometer}" if thermometer else ""
    return streams | temperature, notes, {thermometer}


def _inertial(log: ULog) -> Streams:
    """Return rate and specific force: sensor_combined, else the filtered values for the controllers."""
    topic = log.first("sensor_combined")
    if topic and "gyro_rad[2]" in topic:
        accel_s = topic.times_s()
        if "accelerometer_timestamp_relative" in topic:
            later = topic.column("accelerometer_timestamp_relative")
            accel_s = np.where(later == NOT_SAMPLED, np.nan, accel_s + later * 1e-6)
        gyro, accel = (_body(topic, name) for name in ("gyro_rad[{}]", "accelerometer_m_s2[{}]"))
        return {
            "gyro": Stream(topic.times_s(), vector_columns("gyro", gyro)),
            "accel": Stream(accel_s, vector_columns("accel", accel)),
        }
    names = (("gyro", "vehicle_angular_velocity"), ("accel", "vehicle_acceleration"))
    found = {group: topic for group, name in names if (topic := log.first(name)) and "xyz[2]" in topic}
    return {
        group: Stream(sample_times_s(topic), vector_columns(group, _body(topic, "xyz[{}]")))
        for group, topic in found.items()
    }


def _body(topic: UlogTopic, name: str) -> Array:
    """Return a vector in FRD, whose components' names have 0, 1, 2 in place of {}, in FLU: (n, 3)."""
    return flu_from_frd(topic.vectors(*(name.format(k) for k in range(3))))


def _phase(log: ULog) -> Streams:
    status = log.first("vehicle_status")
    if status is None or "nav_state" not in status:
        return {}
    states, inverse = np.unique(status.column("nav_state"), return_inverse=True)
    words = np.array([MODES.get(int(state), f"mode {state}") for state in states])
    return {"phase": Stream(status.times_s(), {"phase": words[inverse]}, {"phase": Interpolation.HELD}, np.inf)}


def _position(log: ULog) -> tuple[Streams, str]:
    """Return position and place; the position from the local estimate, else from GPS, and a note of the latter."""
    gps = fixes(log)
    streams: Streams = {}
    if gps:
        streams["place"] = Stream(gps.times_s, dict(zip((LATITUDE, LONGITUDE, ALTITUDE), gps.place.T, strict=True)))
    local, enu_m = log.first("vehicle_local_position"), _local_enu_m(log)
    known = np.isfinite(enu_m).all(axis=1).mean() if len(enu_m) else 0.0
    if local and known > (1 - MOST_MISSING if gps else 0.0):
        streams["position"] = Stream(sample_times_s(local), vector_columns("position", enu_m))
        return streams, ""
    if gps is None:
        return streams, ""
    streams["position"] = Stream(gps.times_s, vector_columns("position", local_enu(gps.place)))
    return streams, "position from GPS, relative to the first fix"


def _local_enu_m(log: ULog) -> Array:
    """Return the local estimate east, north, up (n, 3), NaN where PX4 says that it is not valid."""
    local = log.first("vehicle_local_position")
    if local is None or not {"x", "y", "z"} <= set(local.names):
        return np.empty((0, 3))
    flags = [local.column(name) != 0 for name in ("xy_valid", "z_valid") if name in local]
    valid = np.logical_and.reduce([np.ones(len(local), np.bool_), *flags])
    return np.where(valid[:, None], local.vectors("y", "x", "z") * (1.0, 1.0, -1.0), np.nan)


def _temperature(log: ULog, magnetometer: UlogTopic | None) -> tuple[Streams, str]:
    """Return the temperature of the magnetometer, else of the sensor next to it, and the name of its field."""
    for topic, name in _thermometers(log, magnetometer):
        values = topic.column(name).astype(np.float64)
        if np.isfinite(values).mean() > 0.5 and np.ptp(values[np.isfinite(values)]) > 0:
            return {"temperature": Stream(sample_times_s(topic), {TEMPERATURE: values})}, f"{topic.label}.{name}"
    return {}, ""


def _thermometers(log: ULog, magnetometer: UlogTopic | None) -> Sequence[tuple[UlogTopic, str]]:
    names = (
        *(("vehicle_imu_status", "temperature_accel"), ("sensor_accel", "temperature"), ("sensor_baro", "temperature")),
        *(("vehicle_air_data", "baro_temp_celcius"), ("sensor_combined", "baro_temp_celcius")),
    )
    others = [(log.first(topic), name) for topic, name in names]
    return [(topic, name) for topic, name in ((magnetometer, "temperature"), *others) if topic and name in topic]
