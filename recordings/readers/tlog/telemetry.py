"""What one vehicle sends in a telemetry log, on the autopilot's clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from recordings.readers.ardupilot.parameters import Parameters
from recordings.readers.tlog.frames import Frames
from scenarios.arrays import Array

CLOCKS = {"time_boot_ms": 1e-3, "time_usec": 1e-6}
"""Fields of a time by the autopilot, and their units in s."""
SAME_CLOCK_S = 30.0
"""A message's time that is farther than this from its arrival, on the autopilot's clock, is another clock's."""
ARDUPILOT = 3
"""HEARTBEAT.autopilot of ArduPilot."""


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
        """Return the times of frames (n,) on the autopilot's clock, s: the message's own, else that of the arrival."""
        arrived = rows.stamps_s - self.offset_s
        for name, unit_s in CLOCKS.items():
            if name in rows:
                own = np.round(rows.numbers(name) * unit_s, 6)  # equal times in ms and in us are equal numbers
                return own if abs(float(np.median(own - arrived))) < SAME_CLOCK_S else arrived
        return arrived

    @cached_property
    def of_ardupilot(self) -> bool:
        """Whether the sender's heartbeats say that it runs ArduPilot."""
        rows = self.get("HEARTBEAT")
        return rows is not None and float(np.median(rows.numbers("autopilot"))) == ARDUPILOT

    @cached_property
    def parameters(self) -> Parameters:
        """The parameters that ArduPilot sent; none of other autopilots."""
        rows = self.get("PARAM_VALUE")
        if rows is None or not self.of_ardupilot:
            return Parameters()
        return Parameters(rows.words("param_id"), rows.stamps_s - self.offset_s, rows.numbers("param_value"))
