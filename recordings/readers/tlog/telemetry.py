"""What one vehicle sends in a telemetry log, on the autopilot's clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from recordings.readers.ardupilot.parameters import Parameters
from recordings.readers.ardupilot.vehicle import COPTER, PLANE, ROVER, SUB, firmware_in
from recordings.readers.rotations import ARDUPILOT, PX4
from recordings.readers.tlog.frames import Frames
from scenarios.arrays import Array

CLOCKS = {"time_boot_ms": 1e-3, "time_usec": 1e-6}
"""Fields of a time by the autopilot, and their units in s."""
SAME_CLOCK_S = 30.0
"""A message's time that is farther than this from its arrival, on the autopilot's clock, is another clock's."""
AUTOPILOTS = {3: ARDUPILOT, 12: PX4}
"""HEARTBEAT.autopilot -> the autopilot."""
BY_PARAMETER = {"COMPASS_": ARDUPILOT, "CAL_MAG": PX4}
"""The beginning of a parameter's name -> the autopilot that has such parameters."""
WHOLE_TYPE = 6
"""PARAM_VALUE.param_type of a whole number of 32 bits."""
VEHICLES = {
    **dict.fromkeys((2, 3, 4, 13, 14, 15, 29), COPTER),
    **dict.fromkeys((1, 19, 20, 21, 22, 23, 24, 25), PLANE),
    **dict.fromkeys((10, 11), ROVER),
    12: SUB,
}
"""HEARTBEAT.type -> the kind of vehicle that names ArduPilot's modes."""


@dataclass(frozen=True, eq=False)
class Telemetry:
    """The frames of one sender by the names of their messages.

    Messages tell the time since the autopilot's start, the log the receiver's time; the offset between both clocks is
    the median over all messages with `time_boot_ms`, 0 without such messages.
    """

    types: Mapping[str, Frames] = field(default_factory=dict)

    def get(self, name: str) -> Frames | None:
        """Return the frames of a message, None where there are none."""
        return self.types.get(name)

    @cached_property
    def offset_s(self) -> float:
        """The receiver's clock minus the autopilot's."""
        timed = [rows for rows in self.types.values() if "time_boot_ms" in rows]
        lags = [rows.stamps_s - rows.numbers("time_boot_ms") * 1e-3 for rows in timed]
        return float(np.median(np.concatenate(lags))) if lags else 0.0

    def times_s(self, rows: Frames) -> Array:
        """Return the times of frames (n,) on the autopilot's clock, s: the message's own, else that of the arrival.

        Where the autopilot's clock began anew, after a restart or a turn of its counter, the arrival counts.
        """
        arrived = rows.stamps_s - self.offset_s
        for name, unit_s in CLOCKS.items():
            if name in rows:
                own = np.round(rows.numbers(name) * unit_s, 6)  # equal times in ms and in us are equal numbers
                return np.where(np.abs(own - arrived) < SAME_CLOCK_S, own, arrived)
        return arrived

    @cached_property
    def autopilot(self) -> str:
        """ "ardupilot" or "px4", by the sender's heartbeats or else its parameters; "" for others."""
        rows, sent = self.get("HEARTBEAT"), self.get("PARAM_VALUE")
        if rows is not None:
            return AUTOPILOTS.get(int(np.median(rows.numbers("autopilot"))), "")
        names = sent.words("param_id") if sent is not None else []
        return next((one for name in names for start, one in BY_PARAMETER.items() if name.startswith(start)), "")

    @property
    def of_ardupilot(self) -> bool:
        """Whether the sender runs ArduPilot."""
        return self.autopilot == ARDUPILOT

    @cached_property
    def parameters(self) -> Parameters:
        """The parameters that the autopilot sent, none of unknown autopilots; PX4 sends whole numbers by their bits."""
        rows = self.get("PARAM_VALUE")
        if rows is None or not self.autopilot:
            return Parameters()
        values = rows.numbers("param_value")
        if self.autopilot == PX4:
            bits = np.ascontiguousarray(rows.rows["param_value"]).view("<i4").astype(np.float64)
            values = np.where(rows.numbers("param_type") == WHOLE_TYPE, bits, values)
        return Parameters(rows.words("param_id"), rows.stamps_s - self.offset_s, values)

    @cached_property
    def firmware(self) -> tuple[str, tuple[int, int]]:
        """The kind of vehicle, "" where not known, and the release (major, minor), (0, 0) where not known."""
        beats, version, texts = (self.get(name) for name in ("HEARTBEAT", "AUTOPILOT_VERSION", "STATUSTEXT"))
        kind = VEHICLES.get(int(np.median(beats.numbers("type"))), "") if beats is not None else ""
        told_kind, told = firmware_in(texts.words("text") if texts is not None else [])
        if version is not None and (code := int(version.numbers("flight_sw_version")[-1])):
            told = (code >> 24 & 255, code >> 16 & 255)
        return kind or told_kind, told
