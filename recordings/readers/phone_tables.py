"""The sensors of a phone from the tables of Sensor Logger and phyphox, in a recording's units and the device's axes.

x points right, y up the screen and z out of the screen. Sensor Logger writes accelerations and gravity of an iPhone
with the opposite sign unless its setting "standardisation" is on (awesome-sensor-logger, CROSSPLATFORM.md).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import date

import numpy as np
import pyarrow as pa

from recordings.channels import ALTITUDE, LATITUDE, LONGITUDE
from recordings.column_words import ColumnName
from recordings.columns import ATTITUDE
from recordings.decode import NotNumbersError, numbers_of
from recordings.readers.netcdf_file import middle_day
from recordings.readers.packages import TablePackage
from recordings.readers.vehicle_log import vector_columns
from recordings.streams import Interpolation, Stream, interpolated, ordered_rows
from recordings.units import UNITS
from scenarios.arrays import Array

MAGNETOMETERS = {
    "uncalibrated": ("magnetometeruncalibrated", "magnetometer uncalibrated"),
    "calibrated": ("magnetometer", "magnetic field", "raw data"),
}
"""Names of tables in lower case, by the magnetometer: first the one without the phone's own calibration."""
GYROS = ("gyroscope", "gyroscopeuncalibrated")
TOTAL, ACCELEROMETER, GRAVITY = "totalacceleration", "accelerometer", "gravity"
LOCATION, ORIENTATION, ABOUT, CLOCK = "location", "orientation", "metadata", "time"
SENSORS = {*(name for names in MAGNETOMETERS.values() for name in names), *GYROS, TOTAL, ACCELEROMETER, GRAVITY}
DEFAULTS = {"mag": "uT", "gyro": "rad/s", "accel": "m/s^2"}
"""Units of tables whose columns tell none (awesome-sensor-logger, UNITS.md)."""
SECONDS, STAMP_NS, SYSTEM_S = ("seconds_elapsed", "time (s)"), "time", "system time"
"""Columns of time: seconds since the start, one clock for all tables; nanoseconds and seconds since 1970."""
QUATERNION = ("qw", "qx", "qy", "qz")
PLACES = {"latitude": LATITUDE, "longitude": LONGITUDE, "altitude": ALTITUDE, "height": ALTITUDE}
"""Channels by the words of a column, without unit."""
MOST_TILT_DEG = 20.0
"""Median angle between up and the specific force in the world, above which a quaternion stands for another turn."""
Vectors = tuple[Array, Array]
"""Times (n,) in s, and values (n, k)."""


@dataclass
class PhoneTables:
    """The tables of one recording by their names in lower case; notes on what was done.

    about : the tables of phyphox' folder meta, by their names.
    """

    package: TablePackage
    paths: Mapping[str, str]
    about: Mapping[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def table(self, *names: str) -> pa.Table | None:
        """Return the first table of these names that holds rows; None where none does."""
        found = (self.package.table(self.paths[name]) for name in names if name in self.paths)
        return next((table for table in found if table is not None), None)

    def vectors(self, kind: str, *names: str) -> Vectors | None:
        """Return the vectors (n, 3) of a sensor in a recording's unit; None where its tables are not there."""
        table = self.table(*names)
        return None if table is None else vectors_of(table, kind)

    @property
    def is_sensor_logger(self) -> bool:
        """Whether the accelerometer's table is without gravity, as Sensor Logger's is; phyphox' is with gravity."""
        return any(name in self.paths for name in (ABOUT, TOTAL, GRAVITY))

    @property
    def force_sign(self) -> float:
        """-1 for an iPhone whose accelerations are not standardised, else 1."""
        return -1.0 if self._tells("platform", "ios") and not self._tells("standardisation", "true") else 1.0

    @property
    def is_android(self) -> bool:
        """Whether Sensor Logger tells that the phone is an Android."""
        return self._tells("platform", "android")

    def _tells(self, column: str, word: str) -> bool:
        """Return whether Sensor Logger's table about the recording has a word in a column."""
        return ABOUT in self.paths and self.package.words(self.paths[ABOUT]).get(column) == word


def numbers(table: pa.Table, name: str) -> Array | None:
    """Return a column of numbers (n,); None for words."""
    try:
        return numbers_of(table.column(name))
    except (NotNumbersError, pa.ArrowException):
        return None


def seconds_of(table: pa.Table) -> Array | None:
    """Return the times (n,) since the start of the recording."""
    found = next((name for name in table.column_names if name.strip().lower() in SECONDS), None)
    return None if found is None else numbers(table, found)


def vectors_of(table: pa.Table, kind: str) -> Vectors | None:
    """Return the times and the vectors (n, 3) of a table of one sensor, x, y, z in whatever order of the columns."""
    by_part: dict[str, str] = {}
    for name in table.column_names:
        part = ColumnName(name).component("xyz")
        if part is not None:
            by_part.setdefault(part[0], name)
    times = seconds_of(table)
    if set(by_part) != set("xyz") or times is None:
        return None
    parts = [numbers(table, by_part[axis]) for axis in "xyz"]
    known = [part for part in parts if part is not None]
    if len(known) < 3:
        return None
    factor = UNITS[kind].get(ColumnName(by_part["x"]).unit(kind) or DEFAULTS[kind], (1.0, 0.0))[0]
    rows = ordered_rows(times)[0] if np.isfinite(times).any() else np.array([], np.int64)
    with np.errstate(over="ignore"):  # what is too large for a field is infinite, and told as damaged
        return times[rows], factor * np.column_stack(known)[rows]


def specific_force(phone: PhoneTables) -> Vectors | None:
    """Return the specific force, of an iPhone's tables with the sign turned unless standardised."""
    found = phone.vectors("accel", TOTAL) or _summed_force(phone)
    if found is None or phone.force_sign > 0:
        return found
    phone.notes.append("an iPhone's accelerations, not standardised: their sign was turned")
    return found[0], -found[1]


def _summed_force(phone: PhoneTables) -> Vectors | None:
    """Return phyphox' accelerometer, or Sensor Logger's and gravity together; None where gravity is not there."""
    linear, gravity = (phone.vectors("accel", name) for name in (ACCELEROMETER, GRAVITY))
    if linear is None or not phone.is_sensor_logger:
        return linear
    if gravity is None:
        phone.notes.append("the accelerometer's table is without gravity, and there is no table of gravity: left out")
        return None
    phone.notes.append("the specific force is the acceleration and gravity together")
    return linear[0], linear[1] + interpolated(linear[0], *gravity, Interpolation.LINEAR)


def attitude(phone: PhoneTables, force: Vectors | None) -> dict[str, Stream]:
    """Return the orientation of an Android, device to east, north, up; nothing where it does not lift the force up."""
    found = _quaternions(phone)
    if found is None or force is None:
        return {}
    if not phone.is_android or tilt_deg(*found, force) > MOST_TILT_DEG:
        phone.notes.append("the orientation's quaternion has no known world, or does not lift gravity up: left out")
        return {}
    phone.notes.append("the orientation takes its heading from this same magnetometer, from magnetic north")
    how = dict.fromkeys(ATTITUDE, Interpolation.SLERP)
    return {ORIENTATION: Stream(found[0], vector_columns("attitude", found[1]), how)}


def _quaternions(phone: PhoneTables) -> Vectors | None:
    """Return times and unit quaternions (n, 4), w x y z; None where they are not logged, or one is zero."""
    table = phone.table(ORIENTATION)
    times = None if table is None else seconds_of(table)
    if table is None or times is None or not set(QUATERNION) <= set(table.column_names):
        return None
    parts = [part for name in QUATERNION if (part := numbers(table, name)) is not None]
    if len(parts) < len(QUATERNION):
        return None
    q = np.column_stack(parts)
    size = np.linalg.norm(q, axis=1, keepdims=True)
    return (times, q / size) if np.all(size > 0) else None


def tilt_deg(times: Array, q: Array, force: Vectors) -> float:
    """Return the median angle between up and the specific force turned by quaternions (n, 4), device to world."""
    value = interpolated(times, *force, Interpolation.LINEAR)
    w, x, y, z = q.T
    up = np.column_stack([2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z])  # the last row of R
    cosine = np.sum(up * value, axis=1) / np.maximum(np.linalg.norm(value, axis=1), 1e-9)
    return float(np.degrees(np.arccos(np.clip(np.nanmedian(cosine), -1, 1))))


def location(phone: PhoneTables) -> dict[str, Stream]:
    """Return latitude, longitude and altitude of the fixes."""
    table = phone.table(LOCATION)
    times = None if table is None else seconds_of(table)
    if table is None or times is None:
        return {}
    channels = {name: PLACES.get(" ".join(ColumnName(name).words), "") for name in table.column_names}
    found = {channel: numbers(table, name) for name, channel in channels.items() if channel}
    columns = {channel: values for channel, values in found.items() if values is not None}
    return {LOCATION: Stream(times, columns)} if {LATITUDE, LONGITUDE} <= columns.keys() else {}


def recorded_on(phone: PhoneTables) -> date | None:
    """Return the day of a recording: from Sensor Logger's stamps, or phyphox' table of its clock."""
    stamps = _column(phone.table(*(name for names in MAGNETOMETERS.values() for name in names)), STAMP_NS)
    if stamps is not None:
        return middle_day(stamps / 1e9)
    clock = phone.package.table(phone.about[CLOCK]) if CLOCK in phone.about else None
    seconds = _column(clock, SYSTEM_S)
    return None if seconds is None else middle_day(seconds)


def _column(table: pa.Table | None, name: str) -> Array | None:
    return None if table is None or name not in table.column_names else numbers(table, name)
