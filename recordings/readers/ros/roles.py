"""What a bag's topics stand for, by message type: fields of a message and a recording's columns."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from recordings.channels import ARMED, BATTERY_VOLTAGE, TEMPERATURE, THROTTLE, current_name
from recordings.columns import ACCEL, ATTITUDE, GYRO, POSITION
from recordings.readers.ros.bag import Topic
from recordings.readers.ros.fields import MOST_MEMBERS, Layout
from recordings.readers.ros.own_types import own_field
from scenarios.arrays import Array

MAGNETIC, IMU, FIX = "sensor_msgs/msg/MagneticField", "sensor_msgs/msg/Imu", "sensor_msgs/msg/NavSatFix"
THERMOMETER, BATTERY = "sensor_msgs/msg/Temperature", "sensor_msgs/msg/BatteryState"
ODOMETRY, POSE = "nav_msgs/msg/Odometry", "geometry_msgs/msg/PoseStamped"
POSE_COVARIANCE, VECTOR = "geometry_msgs/msg/PoseWithCovarianceStamped", "geometry_msgs/msg/Vector3Stamped"
STATE, RC_OUT = "mavros_msgs/msg/State", "mavros_msgs/msg/RCOut"
HUD = ("mavros_msgs/msg/VFR_HUD", "mavros_msgs/msg/VfrHud")
ESCS = {"mavros_msgs/msg/ESCTelemetry": "esc_telemetry", "mavros_msgs/msg/ESCStatus": "esc_status"}
"""Types with a sequence of motors, and the sequence."""
WITH_SEQUENCES = frozenset((*ESCS, BATTERY, RC_OUT))
"""Types that are read although they hold sequences: of others only those of a fixed size are."""
INFRASTRUCTURE = (
    "rcl_interfaces/",
    "rosgraph_msgs/",
    "tf2_msgs/",
    "visualization_msgs/",
    "bond/",
    "std_msgs/msg/Header",
)
"""Starts of types that measure nothing."""
PLANNED = ("setpoint", "goal", "target", "command", "cmd", "desired", "reference", "waypoint")
"""Words of topics whose poses are where a vehicle should be."""
POSES = {ODOMETRY: "pose.pose", POSE: "pose", POSE_COVARIANCE: "pose.pose"}
"""Types with a pose, the better ones first, and its path."""
TARGETS = {
    IMU: (*GYRO, *ACCEL, *ATTITUDE),
    THERMOMETER: (TEMPERATURE,),
    BATTERY: (BATTERY_VOLTAGE, current_name(1)),
    STATE: ("phase", ARMED),
    **dict.fromkeys(HUD, (THROTTLE,)),
    **dict.fromkeys(ESCS, tuple(map(current_name, range(1, MOST_MEMBERS + 1)))),
    **dict.fromkeys(POSES, (*POSITION, *ATTITUDE)),
}
ALWAYS = (MAGNETIC, FIX)
"""Types that are read whatever is wanted: the place and the date do not depend on columns."""


def is_read(wanted: Callable[[str], bool], name: str, kind: str, layout: Layout) -> bool:
    """Return whether a topic is read: a magnetometer, a fix, or numbers among which some are wanted."""
    if kind in ALWAYS or is_field_vector(name, kind) or (is_own(kind) and own_field(name, layout.names)):
        return True
    if kind.startswith(INFRASTRUCTURE) or (layout.sequences and kind not in WITH_SEQUENCES):
        return False
    return any(wanted(one) for one in (*TARGETS.get(kind, ()), *(f"{name}.{path}" for path in layout.names)))


def is_own(kind: str) -> bool:
    """Return whether a type is a project's own, in which a magnetometer may stand under any name."""
    return not kind.startswith((*INFRASTRUCTURE, "sensor_msgs/", "geometry_msgs/", "nav_msgs/", "std_msgs/"))


def is_field_vector(name: str, kind: str) -> bool:
    """Return whether a vector without a meaning of its own is a magnetometer, by the last word of its topic."""
    last = name.rstrip("/").rsplit("/", 1)[-1].lower()
    return kind == VECTOR and last.startswith(("mag", "compass"))


def nearness(topic: Topic, magnetometer: Topic) -> tuple[bool, int, int]:
    """Return how near a topic's sensor is to a magnetometer: the same frame, the start of the name, the rate."""
    shared = 0
    for ours, theirs in zip(topic.name.split("/"), magnetometer.name.split("/"), strict=False):
        if ours != theirs:
            break
        shared += 1
    return (frame_of(topic) == frame_of(magnetometer), shared, len(topic.received_ns))


def frame_of(topic: Topic) -> str:
    """Return the frame of a topic's first message."""
    return str(topic.frames[0])


def nearest(topics: Iterable[Topic], magnetometer: Topic) -> Topic | None:
    """Return the topic whose sensor is nearest to a magnetometer, None without a topic."""
    return max(topics, key=lambda topic: nearness(topic, magnetometer), default=None)


def vector_of(topic: Topic, path: str, parts: Sequence[str] = "xyz") -> Array:
    """Return the vector at a path of a message, (n, k)."""
    return topic.vector(*(f"{path}.{part}" for part in parts))


def has_vector(topic: Topic, path: str) -> bool:
    """Return whether a vector of an IMU is measured: its covariance does not begin with -1, values are not all zero."""
    covariance = topic.columns.get(f"{path}_covariance[0]")
    values = vector_of(topic, path, "wxyz" if path == "orientation" else "xyz")
    return not (covariance is not None and covariance[0] == -1) and bool(np.any(np.nan_to_num(values) != 0))


def is_planned(topic: Topic) -> bool:
    """Return whether a topic's poses are commanded, not measured."""
    return any(word in topic.name.lower() for word in PLANNED)


def has_fix(topic: Topic) -> NDArray[np.bool_]:
    """Return in which messages of satellite navigation the place is known, (n,)."""
    place = topic.vector("latitude", "longitude")
    return np.asarray((topic.columns["status.status"] >= 0) & np.isfinite(place).all(axis=1) & (place != 0).any(axis=1))
