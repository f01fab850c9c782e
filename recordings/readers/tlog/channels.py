"""Every other number of a telemetry log, as channels under MAVLink's names: `VFR_HUD.airspeed`, `RC_CHANNELS.rssi`."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from recordings.readers.tlog.frames import Frames
from recordings.readers.tlog.telemetry import CLOCKS, Telemetry
from recordings.streams import Interpolation, Stream
from scenarios.arrays import Array

LEFT_OUT = re.compile(
    r"PARAM_\w+|STATUSTEXT\w*|TIMESYNC|SYSTEM_TIME|AUTOPILOT_VERSION|HEARTBEAT|MISSION_\w+|COMMAND_\w+|LOG_\w+|"
    r"FILE_\w+|FENCE_\w+|RALLY_\w+|HOME_POSITION|GPS_GLOBAL_ORIGIN|NAMED_VALUE\w*|DEBUG\w*|"
    r"ATTITUDE\w*|AHRS\w*|EKF_\w+|ESTIMATOR_\w+|GLOBAL_POSITION\w*|LOCAL_POSITION\w*|NAV_CONTROLLER_OUTPUT|ODOMETRY|"
    r"VIBRATION_\w+|MAG_CAL_\w+|SENSOR_OFFSETS|SIMSTATE|SIM_STATE|HIL_\w+|RAW_IMU|SCALED_IMU[23]?|HIGHRES_IMU"
)
"""Messages about the link or the log, states a filter computes from the compasses, and messages read elsewhere."""
OWN = re.compile(
    r"GPS_RAW_INT\.(lat|lon|alt)|SYS_STATUS\.(current|voltage)_battery|VFR_HUD\.(throttle|heading)|"
    r"ESC_TELEMETRY_\w+\.current\[\d\]|\w+\.target_(system|component)|SERVO_OUTPUT_RAW\.port"
)
"""Values that the recording has under names of its own, and addresses."""
FEWEST = 3
"""Frames of which a channel is made."""


def channel_streams(log: Telemetry, wanted: Callable[[str], bool]) -> dict[str, Stream]:
    """Return a stream for each message and instance with wanted channels."""
    found: dict[str, Stream] = {}
    for name, rows in sorted(log.types.items()):
        if not LEFT_OUT.fullmatch(name):
            found |= {label: _stream(log, one, label, wanted) for label, one in _instances(rows).items()}
    return {label: stream for label, stream in found.items() if stream.columns}


def _instances(rows: Frames) -> dict[str, Frames]:
    """Return the frames of each instance with enough of them, by the name of the message and its instance."""
    if not rows.instance or rows.rows[rows.instance].dtype.kind not in "iu":
        return {rows.name: rows} if len(rows) >= FEWEST else {}
    numbers, counts = np.unique(rows.rows[rows.instance], return_counts=True)
    labels = {n: f"{rows.name}[{n}]" if len(numbers) > 1 else rows.name for n in numbers[counts >= FEWEST].tolist()}
    return {label: rows.where(rows.rows[rows.instance] == n) for n, label in labels.items()}


def _stream(log: Telemetry, rows: Frames, label: str, wanted: Callable[[str], bool]) -> Stream:
    columns: dict[str, Array] = {}
    held: dict[str, Interpolation] = {}
    for field in _fields(rows):
        own = {name: values for name, values in _numbered(rows, field, label).items() if wanted(name)}
        columns |= {name: values for name, values in own.items() if not OWN.fullmatch(name)}
        if rows.rows.dtype[field].base.itemsize == 1:
            held |= dict.fromkeys(own.keys() & columns.keys(), Interpolation.HELD)
    return Stream(log.times_s(rows), columns, held)


def _fields(rows: Frames) -> list[str]:
    """Return the fields of numbers, but for times and the instance."""
    kinds = {name: rows.rows.dtype[name].base.kind for name in rows.rows.dtype.names or ()}
    return [name for name, kind in kinds.items() if kind in "iuf" and name not in CLOCKS and name != rows.instance]


def _numbered(rows: Frames, field: str, label: str) -> dict[str, Array]:
    """Return a field by its channel's name, or the places of an array as `field[0]`, `field[1]`, ..."""
    values = rows.numbers(field)
    finite = np.where(np.isfinite(values), values, np.nan)
    if finite.ndim == 1:
        return {f"{label}.{field}": finite}
    return {f"{label}.{field}[{k}]": column for k, column in enumerate(finite.T)}
