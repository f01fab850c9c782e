"""Every other number of a PX4 log as a channel, under the log's own names."""

from __future__ import annotations

import re
from collections.abc import Set
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.readers.base import Wanted
from recordings.readers.px4.contents import ULog, UlogTopic
from recordings.streams import Interpolation, Stream, ordered_rows

READ: dict[str, tuple[str, ...]] = {
    "sensor_mag": ("x", "y", "z"),
    "vehicle_magnetometer": ("magnetometer_ga",),
    "sensor_combined": ("gyro_rad", "accelerometer_m_s2", "magnetometer_ga"),
    "vehicle_attitude": ("q",),
    "vehicle_local_position": ("x", "y", "z"),
    "vehicle_status": ("nav_state",),
    "actuator_motors": ("control",),
    "actuator_armed": ("armed",),
    **dict.fromkeys(
        ("vehicle_gps_position", "sensor_gps"),
        ("lat", "lon", "alt_ellipsoid", "latitude_deg", "longitude_deg", "altitude_ellipsoid_m", "time_utc_usec"),
    ),
}
"""Fields that are read under a recording's names, in all instances."""
MOST_CHANNELS, MOST_VALUES = 5_000, 40_000_000
"""Channels, and values of all channels (320 MB), beyond which others are left out; logs of PX4 have below 2000."""
CAUSES = ("battery", "esc", "actuator", "sensor", "vehicle_imu", "vehicle_thrust", "system_power", "cpuload")
"""Topics that come first, since they tell what may disturb a magnetometer."""
ANGLE = re.compile(r"\.(yaw|yaw_body|heading|cog_rad)$")
"""Channels in radians that jump by a turn."""
LEAST_SAMPLES = 2
"""Samples, in the order of time, below which a topic is an event."""


def channel_streams(log: ULog, used: Set[str], wanted: Wanted, samples: int) -> tuple[dict[str, Stream], str]:
    """Return the numeric fields that change as channels, and a note of those beyond the limits.

    Channels are `topic.field`, of later instances `topic[1].field`. used : names of fields that are read already.
    samples : of the magnetometer, to whose times the channels come. Real numbers are interpolated; whole numbers and
    flags are held.
    """
    most = min(MOST_CHANNELS, MOST_VALUES // max(samples, 1))
    streams: dict[str, Stream] = {}
    found = 0
    for topic in sorted(log.topics.values(), key=lambda topic: not topic.name.startswith(CAUSES)):
        rows, _ = ordered_rows(topic.times_s())
        columns = _columns(topic, used, wanted) if len(rows) >= LEAST_SAMPLES else {}
        kept = {own: columns[own][rows] for own in list(columns)[: max(most - found, 0)]}
        found += len(columns)
        if kept:
            how = {own: _interpolation(own, values) for own, values in kept.items()}
            streams[topic.label] = Stream(topic.times_s()[rows], kept, how)
    return (
        streams,
        f"{found - most} of {found} channels left out: more than memory is meant for" if found > most else "",
    )


def _columns(topic: UlogTopic, used: Set[str], wanted: Wanted) -> dict[str, NDArray[Any]]:
    """Return the fields of a topic that change and that nothing else reads, by the name of their channel."""
    read = READ.get(topic.name, ())
    names = {f"{topic.label}.{name}": name for name in topic.names if name.partition("[")[0] not in read}
    wished = {own: name for own, name in names.items() if "timestamp" not in name and own not in used and wanted(own)}
    columns = {own: topic.column(name) for own, name in wished.items()}
    return {own: values for own, values in columns.items() if _changes(values)}


def _interpolation(name: str, values: NDArray[Any]) -> Interpolation:
    """Return how a channel is carried: whole numbers and flags held, angles about the vertical across their jump."""
    if values.dtype.kind != "f":
        return Interpolation.HELD
    return Interpolation.ANGLE_RAD if ANGLE.search(name) else Interpolation.LINEAR


def _changes(values: NDArray[np.generic]) -> bool:
    """Return whether a field (n,) has two different values."""
    return bool(np.any(values[1:] != values[:1]) and (values.dtype.kind != "f" or np.isfinite(values).any()))
