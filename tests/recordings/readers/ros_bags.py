"""ROS bags as a test writes them: topics of messages, through the library's writers and serialisers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

MAVROS = {
    "mavros_msgs/msg/State": "std_msgs/Header header\nbool connected\nbool armed\nstring mode\nuint8 system_status\n",
    "mavros_msgs/msg/ESCStatusItem": "std_msgs/Header header\nint32 rpm\nfloat32 voltage\nfloat32 current\n",
    "mavros_msgs/msg/ESCStatus": "std_msgs/Header header\nmavros_msgs/ESCStatusItem[] esc_status\n",
    "mavros_msgs/msg/VfrHud": "std_msgs/Header header\nfloat32 airspeed\nfloat32 throttle\nfloat32 climb\n",
}
"""Messages that the library does not know, by type: what tests need of them."""
SINGLE, MESSAGE, ARRAY = 1, 2, 3
"""Kinds of a field as the library describes types."""
NOTHING: dict[str, Any] = {"string": "", "bool": False}
"""What a field is that nobody gives, by type; 0 else."""


@dataclass(frozen=True)
class Series:
    """A topic: type, fields of each message, times of stamps and of receipt in ns; stamp 0 is not set."""

    topic: str
    kind: str
    messages: Sequence[dict[str, Any]]
    stamp_ns: Sequence[int]
    frame: str = "base_link"
    late_ns: int = 3_000_000

    def received(self) -> Iterator[tuple[int, int, dict[str, Any]]]:
        """Yield time of receipt, stamp and fields."""
        for stamp, fields in zip(self.stamp_ns, self.messages, strict=True):
            yield abs(stamp) + self.late_ns, max(stamp, 0), fields


class Types:
    """The message types of ROS 1 Noetic or of ROS 2 Humble, with those of MAVROS."""

    def __init__(self, ros: int) -> None:
        self.ros = ros
        self.store = get_typestore(Stores.ROS1_NOETIC if ros == 1 else Stores.ROS2_HUMBLE)
        types: dict[str, Any] = {}
        for kind, text in MAVROS.items():
            types.update(get_types_from_msg(text, kind))
        self.store.register(types)

    def make(self, kind: str, fields: dict[str, Any]) -> Any:
        """Return a message; fields that are not given are zero or empty."""
        described = self.store.fielddefs[kind][1]
        return self.store.types[kind](**{name: self._value(one, fields.get(name)) for name, one in described})

    def _value(self, description: Any, given: Any) -> Any:
        """Return what is given for a field, a nested message from its fields, or nothing in the field's type."""
        node, what = int(description[0]), description[1]
        if node == MESSAGE and (given is None or isinstance(given, dict)):
            return self.make(what, given or {})
        if given is not None:
            return given
        if node == SINGLE:
            return NOTHING.get(what[0], 0)
        (_, inner), size = what
        return np.zeros(size if node == ARRAY else 0, np.dtype(inner[0]))

    def stamped(self, kind: str, stamp_ns: int, frame: str, fields: dict[str, Any]) -> bytes:
        """Return a message with a header as bytes."""
        stamp = {"sec": stamp_ns // 10**9, "nanosec": stamp_ns % 10**9}
        message = self.make(kind, {"header": {"stamp": stamp, "frame_id": frame}, **fields})
        serialize = self.store.serialize_ros1 if self.ros == 1 else self.store.serialize_cdr
        return bytes(serialize(message, kind))


def write_bag(path: Path, series: Sequence[Series], ros: int = 2, storage: StoragePlugin = StoragePlugin.MCAP) -> None:
    """Write a ROS 1 bag, or a ROS 2 directory, in the order of receipt."""
    types = Types(ros)
    writer: Any = Writer1(path) if ros == 1 else Writer2(path, version=9, storage_plugin=storage)
    with writer:
        rows = []
        for one in series:
            connection = writer.add_connection(one.topic, one.kind, typestore=types.store)
            rows += [
                (received, connection, types.stamped(one.kind, stamp, one.frame, fields))
                for received, stamp, fields in one.received()
            ]
        for received, connection, raw in sorted(rows, key=lambda row: row[0]):
            writer.write(connection, received, raw)


def vector(values: Sequence[float], names: str = "xyz") -> dict[str, float]:
    """Return the fields of a vector or a quaternion."""
    return dict(zip(names, map(float, values), strict=True))
