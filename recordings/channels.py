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
"""The channel of the height, or with the other sign the depth: of the sensor's place, where it is known."""
SCALAR = "scalar_nT"
"""The channel of a magnetometer that measures the field's strength alone."""

REFERENCE = ("reference_x_nT", "reference_y_nT", "reference_z_nT")
"""The channels of a second magnetometer, whose reading is the field that the first is compared with."""

LATITUDE, LONGITUDE, ALTITUDE = "latitude_deg", "longitude_deg", "altitude_m"
"""The channels of a place: geodetic, altitude above the ellipsoid in metres (0 where it was not logged)."""


def current_name(motor: int) -> str:
    """The channel of a motor's current, motors counted from 1."""
    return f"current_{motor}_A"


def motors_among(channels: Iterable[str]) -> tuple[int, ...]:
    """The motors whose currents are among the channels, ascending; numbers may be missing between them."""
    found = map(_CURRENT.fullmatch, channels)
    return tuple(sorted(int(match[1]) for match in found if match))


def currents_of(current_A: Array) -> dict[str, Array]:
    """Motor currents (n, m) as channels."""
    return {current_name(motor): values for motor, values in enumerate(current_A.T, start=1)}
