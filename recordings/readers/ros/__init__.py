"""ROS bags: ROS 1 `.bag`, ROS 2 directories with `metadata.yaml`, `.db3`, and `.mcap`."""

from __future__ import annotations

from pathlib import Path

from recordings.readers.base import FileContents, FileFormat, Wanted
from recordings.readers.ros.bag import MCAP_MARK, METADATA, METADATA_MARK, ROS1_MARK, SQLITE_MARK, read_bag
from recordings.readers.ros.log import BagLog, magnetometers_of
from recordings.readers.ros.roles import is_read
from scenarios.errors import InputError

__all__ = ["ROS"]

MARKS = {".bag": ROS1_MARK, ".mcap": MCAP_MARK, ".db3": SQLITE_MARK}
"""First bytes by suffix."""


def _recognises(path: Path, head: bytes) -> bool:
    return head.startswith(tuple(MARKS.values())) or (path.name == METADATA and METADATA_MARK in head)


def _read(path: Path, wanted: Wanted, stream: str | None) -> FileContents:
    """Read the topics of a bag at the times of one magnetometer; `stream` is its topic."""
    with path.open("rb") as file:
        head = file.read(len(SQLITE_MARK))
    suffix = next((suffix for suffix, mark in MARKS.items() if head.startswith(mark)), None)
    if suffix is not None and path.suffix != suffix:
        what = f"is a ROS bag by its first bytes, not by its name {path.name}"
        raise InputError(what, where=str(path), do=f"rename it to {path.stem}{suffix}")
    bag = read_bag(path, lambda name, kind, layout: is_read(wanted, name, kind, layout))
    found = magnetometers_of(bag)
    if not found:
        topics = ", ".join(f"{topic.name} ({topic.kind})" for topic in bag.topics.values())[:200]
        what = f"holds no message of sensor_msgs/MagneticField; it holds {topics or 'no numbers'}"
        raise InputError(what, where=str(path), do="record the magnetometer's topic")
    return BagLog(bag, found).vehicle_log().contents(path, wanted, stream)


ROS = FileFormat(
    name="ROS bag",
    suffixes=(".bag", ".mcap", ".db3"),
    summary="a ROS 1 or ROS 2 bag, or its directory",
    extra="ros",
    remark="tesla, REP 103; topics by name, MAVROS too",
    recognises=_recognises,
    read=_read,
    marker=METADATA,
)
