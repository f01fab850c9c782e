"""A blackbox log as a vehicle's: counts of the magnetometer in the body frame, and what stands in the same frames."""

from __future__ import annotations

import math

import numpy as np

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
from recordings.columns import ATTITUDE, POSITION
from recordings.readers.base import Wanted
from recordings.readers.blackbox.frames import DecodedLog, FramesOfKind
from recordings.readers.blackbox.modes import ARM, INAV, phases_of
from recordings.readers.navigation import east_north_m, enu_of_angles, median_place
from recordings.readers.vehicle_log import Columns, VehicleLog, vector_columns
from recordings.reading import COUNT
from recordings.streams import Interpolation, Stream
from recordings.units import STANDARD_GRAVITY_M_S2
from scenarios.arrays import Array

SCALED_QUATERNION = 32767.0
"""The `imuQuaternion` of a component of one."""
HIGH_RESOLUTION = 10.0
"""Factor of gyro and stick commands where `blackbox_high_resolution` is set."""
DEGREES = 1e-7
DECIDEGREE = math.radians(0.1)
FEWEST_SATELLITES = 5
"""Satellites of a fix that counts."""
PULSE_US = (1000.0, 2000.0)
"""Least and largest throttle command where the header does not tell."""
MEASURED = ("loopIteration", "time", "magADC", "gyroADC", "gyroData", "accSmooth", "imuQuaternion", "attitude")
"""Fields that are no channels, with and without a number in brackets."""
NOT_UNDONE = {
    "Betaflight": "magADC is rotated to the body, less mag_calibration: the log does not hold them, nothing is undone",
    INAV: "magADC is rotated to the body, less magzero_x .., over maggain_x ..: the log does not hold them, "
    "nothing is undone",
}


class BlackboxLog:
    """A decoded log under a recording's names, in units and frames of a recording."""

    def __init__(self, name: str, log: DecodedLog, wanted: Wanted) -> None:
        self.name, self.log, self.header, self.wanted = name, log, log.header, wanted
        self.inav = self.header.firmware == INAV
        self.fine = HIGH_RESOLUTION if self.header.number("blackbox_high_resolution", 0.0) == 1 else 1.0
        self.notes = list(log.notes)
        self.used: set[str] = set()

    def vehicle_log(self) -> VehicleLog:
        """Return the log; the counts of the magnetometer are FLU, as the log's other vectors."""
        main = self.log.main
        magnetometer = main.vector("magADC")
        fields = vector_columns("mag", magnetometer if magnetometer is not None else np.zeros((0, 3)))
        found = {**self._motion(), **self._power(), **self._motors()}
        streams = {"main": Stream(main.times_s, {**found, **self._channels(main)}, self._slerp(found))}
        streams |= self._slow() | self._fixes("pos_up_m" in found)
        kind = INAV if self.inav else "Betaflight"
        scale = "counts of the magnetometer's driver: the scale is that of the known field strength"
        rows = f"{len(main.times_s)} new readings of the magnetometer are the samples; repeated readings are left out"
        return VehicleLog(
            {self.name: Stream(main.times_s, fields)},
            streams,
            (rows, NOT_UNDONE[kind], scale, *self.notes),
            frame="flu",
            unit=COUNT,
            place=self.place,
            date=self.header.date,
        )

    def _note(self, column: str, line: str) -> None:
        """Take a note about a column that is wanted."""
        self.notes += [line] if self.wanted(column) else []

    @staticmethod
    def _slerp(columns: Columns) -> dict[str, Interpolation]:
        return dict.fromkeys(ATTITUDE, Interpolation.SLERP) if ATTITUDE[0] in columns else {}

    def _motion(self) -> Columns:
        """Return rate, specific force, attitude, and INAV's position."""
        main, found = self.log.main, Columns()
        rate = main.vector("gyroADC")
        rate = main.vector("gyroData") if rate is None else rate
        force, place = main.vector("accSmooth"), main.vector("navPos")
        if rate is not None:
            found |= vector_columns("gyro", rate * self.header.gyro_scale / self.fine)
        if force is not None and self.header.number("acc_1G", 0.0) > 1:
            found |= vector_columns("accel", force * STANDARD_GRAVITY_M_S2 / self.header.number("acc_1G", 1.0))
        attitude = self._attitude()
        if attitude is not None:
            found |= vector_columns("attitude", attitude)
            self._note(
                ATTITUDE[0], "the attitude's heading comes from this magnetometer: a fit to it is circular in yaw"
            )
        if place is not None:
            self.used |= {f"navPos[{k}]" for k in range(3)}
            found |= vector_columns("position", place[:, [1, 0, 2]] / 100)  # north, east, up in cm
        return found

    def _attitude(self) -> Array | None:
        """Return the attitude (n, 4), FLU to ENU: of a quaternion to north, west, up, or of INAV's angles."""
        vector, angles = self.log.main.vector("imuQuaternion"), self.log.main.vector("attitude")
        if vector is not None:
            return enu_from_nwu(vector / SCALED_QUATERNION)
        if angles is None:
            return None
        roll, pitch, yaw = DECIDEGREE * angles.T
        return enu_of_angles(roll, -pitch, yaw)  # INAV's pitch is positive with the nose down

    def _take(self, name: str) -> Array | None:
        """Return a main field that is no channel under its own name then, None where it is not logged."""
        if name not in self.log.main.columns:
            return None
        self.used.add(name)
        return self.log.main.columns[name].astype(np.float64)

    def _power(self) -> Columns:
        """Return battery voltage and current in units that the firmware's version tells."""
        version = self.header.version
        if not (self.inav or (self.header.firmware == "Betaflight" and version >= 3)):
            return {}
        volts = 0.01 if self.inav or version >= 4 else 0.1
        voltage = self._take("vbat" if self.inav else "vbatLatest")
        current = self._take("amperage" if self.inav else "amperageLatest")
        found = Columns() if voltage is None else {BATTERY_VOLTAGE: volts * voltage}
        if current is not None:
            self._note(current_name(1), "current_1_A is the battery's current")
            found |= {current_name(1): 0.01 * current}
        return found

    def _motors(self) -> Columns:
        """Return motor commands and throttle, 0 to 1 between the header's limits."""
        pulses = self.header.number("minthrottle", PULSE_US[0]), self.header.number("maxthrottle", PULSE_US[1])
        outputs = self.header.numbers("motorOutput")
        outputs = outputs if len(outputs) == 2 else pulses
        found = Columns()
        for motor in range(1, 9):
            values = self._take(f"motor[{motor - 1}]")
            if values is not None:
                found[motor_output_name(motor)] = _share(values, outputs)
        stick = self._take("rcCommand[3]")
        if stick is not None:
            found[THROTTLE] = _share(stick / self.fine, pulses if self.inav else PULSE_US)
        return found

    def _channels(self, main: FramesOfKind) -> Columns:
        """Return the other main fields."""
        return {
            name: values.astype(np.float64)
            for name, values in main.columns.items()
            if name.split("[")[0] not in MEASURED and name not in self.used
        }

    def _slow(self) -> dict[str, Stream]:
        """Return the slow states: modes as words, arming, the IMU's temperature, all held until the next."""
        slow = self.log.slow
        if not len(slow.times_s):
            return {}
        found: Columns = {name: values.astype(np.float64) for name, values in slow.columns.items()}
        found["phase"] = phases_of(slow.columns, self.inav)
        if self.inav and "IMUTemperature" in found:
            found[TEMPERATURE] = 0.1 * found.pop("IMUTemperature")
        if not self.inav and "flightModeFlags" in slow.columns:
            found[ARMED] = (slow.columns["flightModeFlags"] & ARM).astype(np.float64)
        return {"slow": Stream(slow.times_s, found, dict.fromkeys(found, Interpolation.HELD), math.inf)}

    def _good_fixes(self) -> tuple[Array, Array] | None:
        """Return times of fixes, and latitude, longitude in degrees and altitude in m (n, 3); None without any."""
        fixes = self.log.fixes
        place = fixes.vector("GPS_coord", 2)
        if place is None:
            return None
        satellites = fixes.columns.get("GPS_numSat", np.full(len(place), FEWEST_SATELLITES))
        good = (satellites >= FEWEST_SATELLITES) & (place != 0).any(axis=1) & (np.abs(place) <= 1.8e9).all(axis=1)
        metres = 0.1 if self.header.firmware == "Betaflight" and self.header.version >= 4 else 1.0
        altitude = metres * fixes.columns.get("GPS_altitude", np.zeros(len(place)))
        return (fixes.times_s[good], np.column_stack([DEGREES * place, altitude])[good]) if good.any() else None

    @property
    def place(self) -> tuple[float, ...] | None:
        """The median of the fixes."""
        found = self._good_fixes()
        return found and median_place(found[1][:, 0], found[1][:, 1], float(np.median(found[1][:, 2])))

    def _fixes(self, placed: bool) -> dict[str, Stream]:
        """Return the fixes, with the position relative to the first where the log has no position of its own."""
        found = self._good_fixes()
        if found is None:
            return {}
        times_s, place = found
        columns: Columns = dict(zip((LATITUDE, LONGITUDE, ALTITUDE), place.T, strict=True))
        if not placed:
            enu = np.column_stack([*east_north_m(place[:, 0], place[:, 1]), place[:, 2] - place[0, 2]])
            columns |= vector_columns("position", enu)
            self._note(POSITION[0], "position from the satellites' fixes, relative to the first")
        return {"fixes": Stream(times_s, columns)}


def enu_from_nwu(vector: Array) -> Array:
    """Return quaternions w x y z (n, 4), FLU to ENU, of the vector part (n, 3) of FLU to north, west, up, w >= 0.

    q_enu = (cos 45, 0, 0, sin 45) q: north, the x axis, becomes the y axis of east, north, up.
    """
    x, y, z = vector.T
    w = np.sqrt(np.maximum(0.0, 1.0 - x * x - y * y - z * z))
    turned = np.column_stack([w - z, x - y, x + y, w + z])
    return np.asarray(turned / np.linalg.norm(turned, axis=1, keepdims=True))


def _share(values: Array, limits: tuple[float, ...]) -> Array:
    """Return where values lie between two limits, 0 to 1."""
    low, high = limits
    return np.asarray(np.clip((values - low) / (high - low if high > low else 1.0), 0.0, 1.0))
