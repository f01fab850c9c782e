"""ROS bags: ROS 1 `.bag`, ROS 2 `.db3` and `.mcap`, and directories of them, with `metadata.yaml` or without."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from recordings.readers.base import FileContents, FileFormat, Wanted
from recordings.readers.ros.bag import (
    MCAP_MARK,
    METADATA,
    METADATA_MARK,
    ROS1_MARK,
    SQLITE_MARK,
    joined_bags,
    read_bag,
)
from recordings.readers.ros.log import BagLog, magnetometers_of
from recordings.readers.ros.own_types import with_own_fields
from recordings.readers.ros.roles import is_own, is_read
from scenarios.errors import InputError

__all__ = ["ROS"]

MARKS = {".bag": ROS1_MARK, ".mcap": MCAP_MARK, ".db3": SQLITE_MARK}
"""First bytes by suffix."""
ZSTD_MARK, COMPRESSED = b"\x28\xb5\x2f\xfd", b"compression_format: zstd"
"""The first bytes of a file that is compressed, and the line of a bag's metadata that tells of compression."""
MOST_PARTS, MOST_METADATA = 100, 1 << 20
"""Files of a directory without metadata that are read as one recording; bytes of the metadata that are looked at."""


def _recognises(path: Path, head: bytes) -> bool:
    return (
        head.startswith(tuple(MARKS.values()))
        or (path.name == METADATA and METADATA_MARK in head)
        or _is_compressed(path, head)
    )


def _is_compressed(path: Path, head: bytes) -> bool:
    """Return whether a file is a ROS 2 bag that was compressed as a whole."""
    return head.startswith(ZSTD_MARK) and Path(path.stem).suffix in MARKS


def _read(path: Path, wanted: Wanted, stream: str | None) -> FileContents:
    """Read the topics of a bag, or of all bags in a directory, at the times of one magnetometer.

    stream : the topic of the magnetometer.
    """
    files = _files(path)
    bags = [read_bag(file, lambda name, kind, layout: is_read(wanted, name, kind, layout)) for file in files]
    whole = joined_bags(bags) if len(bags) > 1 else bags[0]
    bag = replace(whole, topics=with_own_fields(whole.topics, is_own))
    found = magnetometers_of(bag)
    if not found:
        topics = ", ".join(f"{topic.name} ({topic.kind})" for topic in bag.topics.values())[:200]
        what = f"holds no message of sensor_msgs/MagneticField; it holds {topics or 'no numbers'}"
        raise InputError(what, where=str(path), do="record the magnetometer's topic")
    contents = BagLog(bag, found).vehicle_log().contents(path, wanted, stream)
    told = (f"{len(files)} bags are read as the parts of one recording",) if len(files) > 1 else ()
    return replace(contents, notes=(*told, *contents.notes))


def _files(path: Path) -> list[Path]:
    """Return the files of a bag: its metadata, or the files of one kind in a directory that has none."""
    if not path.is_dir():
        return [_checked(path)]
    if (path / METADATA).is_file():
        return [path / METADATA]
    kinds = (sorted(one for one in path.glob(f"*{suffix}") if one.is_file()) for suffix in MARKS)
    found = next(files for files in kinds if files)
    if len(found) > MOST_PARTS:
        what, do = f"holds {len(found)} bags, at most {MOST_PARTS} are read", "give one of them"
        raise InputError(what, where=str(path), do=do)
    return [_checked(one) for one in found]


def _checked(path: Path) -> Path:
    """Return a bag's file, or the metadata beside a file that is compressed, as is told there alone.

    Raises InputError for a compressed file without metadata, and for a file whose suffix is another kind's.
    """
    with path.open("rb") as file:
        head = file.read(len(SQLITE_MARK))
    beside = path.with_name(METADATA)
    if beside.is_file() and COMPRESSED in beside.read_bytes()[:MOST_METADATA]:
        return beside
    if _is_compressed(path, head):
        raise InputError("is compressed by zstd", where=str(path), do=f"unzstd {path.name}, or give its directory")
    suffix = next((suffix for suffix, mark in MARKS.items() if head.startswith(mark)), None)
    if suffix is not None and path.suffix != suffix:
        what = f"is a ROS bag by its first bytes, not by its name {path.name}"
        raise InputError(what, where=str(path), do=f"rename it to {path.stem}{suffix}")
    return path


ROS = FileFormat(
    name="ROS bag",
    suffixes=(".bag", ".mcap", ".db3"),
    summary="a ROS 1 or ROS 2 bag, or its directory",
    extra="ros",
    remark="tesla, REP 103; topics by name, MAVROS too",
    recognises=_recognises,
    read=_read,
    markers=(METADATA, *(f"*{suffix}" for suffix in MARKS)),
    whole=True,
)
