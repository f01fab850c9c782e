"""Channels of a recording that have a meaning of their own: currents, temperature, height, place, references."""

from __future__ import annotations

import re
from collections.abc import Iterable

from scenarios.arrays import Array

TEMPERATURE = "temperature_degC"
"""The channel of the magnetometer's temperature."""
MOTOR_NUMBER = r"[1-9]\d*"
_CURRENT = re.compile(f"current_({MOTOR_NUMBER})_A")

HEIGHT = "pos_up_m"
"""The channel of the height above the origin, minus the depth."""
SCALAR = "scalar_nT"
"""The channel of a scalar magnetometer, which measures the field's strength alone."""

REFERENCE = ("reference_x_nT", "reference_y_nT", "reference_z_nT")
"""The channels of a reference magnetometer, with whose reading the first is compared."""

LATITUDE, LONGITUDE, ALTITUDE = "latitude_deg", "longitude_deg", "altitude_m"
"""The channels of the geodetic position; the altitude is above the ellipsoid (0 where not logged)."""

THROTTLE, BATTERY_VOLTAGE, ARMED = "throttle", "battery_voltage_V", "armed"
"""The channels of the collective thrust command (0 to 1), of the battery's voltage, and of the armed state (0 or 1)."""

BOOKKEEPING = re.compile(
    r"time|usec|stamp|count|reset|covarian|varianc|innov|estimator|(^|\W)(ekf|[xn]k[a-z0-9]*|dsf|pm|tsyn)\W|crc|checksum"
    r"|(^|[\W_])(seq|valid|id)([\W_]|$)|_valid|device"
)
"""Lower-case names of an autopilot's clocks, counters, and what its estimator says of its own errors."""
OF_MAGNETOMETER = re.compile(r"(^|[\W_])(uncal)?mag(adc)?([\W_x-z]|netic|netometer|$)|compass")
"""Lower-case names of what a magnetometer gave."""


def may_be_cause(name: str) -> bool:
    """Return whether a channel's name allows that it disturbs a magnetometer, or goes with what does.

    Not so: clocks, counters, an estimator's own figures, and what a magnetometer measured.
    """
    low = name.lower()
    return name in REFERENCE or not (BOOKKEEPING.search(low) or OF_MAGNETOMETER.search(low))


def motor_output_name(motor: int) -> str:
    """Return the channel of a motor's command (0 to 1), motors counted from 1."""
    return f"motor_output_{motor}"


def current_name(motor: int) -> str:
    """Return the channel of a motor's current, motors counted from 1."""
    return f"current_{motor}_A"


def motors_of(channels: Iterable[str]) -> tuple[int, ...]:
    """Return the numbers of the motors whose currents are channels, ascending, possibly with gaps."""
    found = map(_CURRENT.fullmatch, channels)
    return tuple(sorted(int(match[1]) for match in found if match))


def currents_of(current_A: Array) -> dict[str, Array]:
    """Return motor currents (n, m) as channels."""
    return {current_name(motor): values for motor, values in enumerate(current_A.T, start=1)}
