"""One block of the truth that effects act on."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from scenarios.errors import InputError

Array = NDArray[np.float64]
MOTION = frozenset({"attitude", "rate", "position"})
"""What an effect may need of the motion; whatever else it needs is a channel."""
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


@dataclass(frozen=True)
class State:
    """The vehicle and its surroundings at one magnetometer's n sample times (a block of a run).

    ================  ============  ====================================================================
    time_s            (n,)          since the start of the run, evenly spaced
    interval_s        float         sample interval
    pos_enu_m         (n, 3)        of the magnetometer (lever arm included)
    R_wb              (n, 3, 3)     body (FLU) to world (ENU)
    rate_rad_s        (n, 3)        body rate, body frame
    field_enu_nT      (3,)          undisturbed Earth field
    field_nT          (n, 3)        undisturbed field in the body frame, R_wb^T field_enu_nT
    field_rate_nT_s   (n, 3)        its time derivative in the body frame, -rate x field
    channels          name -> (n,)  whatever else is simulated or recorded, by the name of its column, unit included:
                                    temperature_degC of the magnetometer, current_1_A, ..., any column of a log
    attitude          str           where R_wb comes from: the simulator's truth, or a recording's navigation
    ================  ============  ====================================================================
    """

    time_s: Array
    interval_s: float
    pos_enu_m: Array
    R_wb: Array
    rate_rad_s: Array
    field_enu_nT: Array
    field_nT: Array
    field_rate_nT_s: Array
    channels: Mapping[str, Array] = field(default_factory=dict)
    attitude: Literal["truth", "navigation"] = "truth"

    def __len__(self) -> int:
        return len(self.time_s)

    def channel(self, name: str) -> Array:
        """A channel (n,); InputError that lists those there are."""
        if name not in self.channels:
            raise missing_channel(name, self.channels)
        return self.channels[name]

    @cached_property
    def motors(self) -> tuple[int, ...]:
        """The numbers of the motors whose currents are known."""
        return motors_among(self.channels)

    @cached_property
    def current_A(self) -> Array:
        """The currents (n, m) of `motors`, m = 0 without any."""
        columns = [self.channels[current_name(motor)] for motor in self.motors]
        return np.column_stack(columns) if columns else np.zeros((len(self), 0))

    def current_of(self, motor: int) -> Array:
        """The current (n,) of a motor by its number, or for 0 of all together; InputError for one that is not there."""
        return self.channel(current_name(motor)) if motor else np.asarray(self.current_A.sum(axis=1))


def missing_channel(name: str, there: Mapping[str, object]) -> InputError:
    """What is said where an effect needs a channel that nobody gives."""
    return InputError(f"needs the channel {name!r}", do="the channels are " + (", ".join(there) or "none"))
