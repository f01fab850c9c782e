"""ROS bags that expand: small files with much in them are refused, and what sensors write is read as before."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, storage_mcap
from rosbags.rosbag2 import Writer as Writer2

from recordings.readers import load
from recordings.readers.ros import expansion
from scenarios.arrays import Array
from scenarios.errors import InputError
from tests.recordings.readers.ros_bags import Types, vector

START_NS = 1_714_564_800 * 10**9
KINDS = ("ros1 bz2", "ros1 lz4", "mcap chunk", "mcap message", "mcap file", "sqlite message", "sqlite file")
MODES = {"chunk": CompressionMode.STORAGE, "message": CompressionMode.MESSAGE, "file": CompressionMode.FILE}


def writer(place: Path, kind: str) -> tuple[Any, Path, Types]:
    """A writer of the library's that compresses, the path that a user would give, and the message types."""
    storage, what = kind.split()
    if storage == "ros1":
        first = Writer1(place / "flight.bag")
        first.set_compression(Writer1.CompressionFormat[what.upper()])
        return first, place / "flight.bag", Types(1)
    plugin = StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3
    second = Writer2(place / "flight", version=9, storage_plugin=plugin)
    second.set_compression(MODES[what], CompressionFormat.ZSTD)
    return second, place / "flight", Types(2)


def write(place: Path, kind: str, frames: list[str], order: list[int] | None = None) -> Path:
    """A bag of samples k nT along x with these frames, every 0.1 s; written in another order than received."""
    opened, path, types = writer(place, kind)
    with opened as file:
        mag = "sensor_msgs/msg/MagneticField"
        connection = file.add_connection("/mag", mag, typestore=types.store)
        for k in order or range(len(frames)):
            stamp = START_NS + k * 10**8
            raw = types.stamped(mag, stamp, frames[k], {"magnetic_field": vector((1e-9 * k, 2e-5, 0))})
            file.write(connection, stamp, raw)
    return path


def field_nT(path: Path) -> Array:
    return load(path, lambda name: True).table["mag_x_nT"].to_numpy()


@pytest.mark.parametrize("kind", KINDS)
def test_compressed_bags_come_back(kind: str, tmp_path: Path) -> None:
    path = write(tmp_path, kind, ["imu"] * 40)
    np.testing.assert_allclose(field_nT(path), np.arange(40), atol=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_a_bag_that_expands_beyond_measure_is_refused(kind: str, tmp_path: Path) -> None:
    """Forty megabytes of one letter in place of a frame's name: some kilobytes compressed."""
    path = write(tmp_path, kind, ["imu"] * 20 + ["x" * 40_000_000])
    tables = dict(storage_mcap.DECOMPRESSORS)
    with pytest.raises(InputError, match=r"expand to more than 30 times the bag \(give a bag"):
        load(path, lambda name: True)
    assert tables == storage_mcap.DECOMPRESSORS


def test_long_texts_do_not_widen_those_of_all_messages(tmp_path: Path) -> None:
    """A thousand texts as wide as one of a megabyte would be four gigabytes."""
    path = write(tmp_path, "mcap chunk", ["imu"] * 1000 + ["x" * 1_000_000])
    assert len(field_nT(path)) == 1000  # the sample of another frame is left out


def test_an_index_that_is_pointed_at_again_and_again_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(expansion, "MOST_INDEXED", 30)
    path = write(tmp_path, "ros1 bz2", ["imu"] * 40)
    with pytest.raises(InputError, match="its index lists more than 30 messages"):
        load(path, lambda name: True)


def test_chunks_out_of_order_are_put_into_the_order_of_receipt(tmp_path: Path) -> None:
    """Several chunks of a megabyte, the later half of the samples in the chunks ahead."""
    path = write(tmp_path, "mcap chunk", ["x" * 200_000] * 40, [*range(20, 40), *range(20)])
    opened = storage_mcap.McapReader(next(path.glob("*.mcap")))
    opened.open()
    assert len(opened.chunks) > 3
    opened.close()
    np.testing.assert_allclose(field_nT(path), np.arange(40), atol=1e-6)


@pytest.mark.parametrize("kind", ["ros1 lz4", "mcap chunk"])
def test_messages_of_another_form_are_not_counted_for_ever(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("recordings.readers.ros.bag.MOST_WRONG", 5)
    opened, path, types = writer(tmp_path, kind)
    with opened as file:
        connection = file.add_connection("/mag", "sensor_msgs/msg/MagneticField", typestore=types.store)
        for k in range(9):
            file.write(connection, START_NS + k, b"\0\1\0\0")
    with pytest.raises(InputError, match="more than 5 messages are of another form"):
        load(path, lambda name: True)
