"""Bags whose sensors are mounted askew, are forward-right-down, or speak types of their own; bags in several files."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.rosbag2.enums import CompressionFormat, CompressionMode
from rosbags.typesys import get_types_from_msg
from scipy.spatial.transform import Rotation

import magbench
from diagnosis.question import file_sources
from recordings.readers import load
from scenarios.arrays import Array
from scenarios.errors import InputError
from tests.recordings.readers import ros_bags
from tests.recordings.readers.flights import FIELD_ENU_NT, Flight, assert_same_flight
from tests.recordings.readers.ros_bags import Series, Types, vector, write_bag
from tests.recordings.readers.test_ros import ns as stamps
from tests.recordings.readers.test_ros import read

FIELD_NT = float(np.linalg.norm(FIELD_ENU_NT))
TIMES_S = np.arange(0.0, 8.0, 0.04)
FLIGHT = Flight(TIMES_S)
FRD, NED_Q = Rotation.from_quat([1, 0, 0, 0]), Rotation.from_quat([np.sqrt(0.5), np.sqrt(0.5), 0, 0])
"""Forward, right, down to forward, left, up; north, east, down to east, north, up."""
TRANSFORMS = "tf2_msgs/msg/TFMessage"
OWN = {
    TRANSFORMS: "geometry_msgs/TransformStamped[] transforms\n",
    "px4_msgs/msg/SensorMag": "uint64 timestamp\nfloat32 x\nfloat32 y\nfloat32 z\nfloat32 temperature\n",
    "boat_msgs/msg/Nine": "std_msgs/Header header\nfloat64[3] acc\nfloat64[3] mag_bias\nfloat64[3] mag_raw\n",
    "boat_msgs/msg/Compass": "std_msgs/Header header\ngeometry_msgs/Vector3 field\nfloat32 heading\n",
}


@pytest.fixture(autouse=True)
def _own_types(monkeypatch: pytest.MonkeyPatch) -> None:
    """Types that the library does not know, for the writer."""
    monkeypatch.setattr(ros_bags, "MAVROS", {**ros_bags.MAVROS, **OWN})
    assert get_types_from_msg(OWN["px4_msgs/msg/SensorMag"], "px4_msgs/msg/SensorMag")


def magnetic(mount: Rotation, frame: str, topic: str = "/imu/mag") -> Series:
    """The field along the axes of a sensor; `mount` turns its axes to the body's."""
    rows = 1e-9 * mount.inv().apply(FLIGHT.field_nT)
    kind = "sensor_msgs/msg/MagneticField"
    return Series(topic, kind, [{"magnetic_field": vector(row)} for row in rows], stamps(TIMES_S), frame)


def imu(mount: Rotation, frame: str, world: Rotation | None = None) -> Series:
    """The IMU along its own axes; `world` turns its world to east, north, up."""
    attitude = (world or Rotation.identity()).inv() * FLIGHT.rotation * mount
    rate, force = (mount.inv().apply(values) for values in (FLIGHT.rate_rad_s, FLIGHT.specific_force_m_s2))
    rows = zip(attitude.as_quat(), rate, force, strict=True)
    messages = [
        {"orientation": vector(q, "xyzw"), "angular_velocity": vector(w), "linear_acceleration": vector(f)}
        for q, w, f in rows
    ]
    return Series("/imu/data", "sensor_msgs/msg/Imu", messages, stamps(TIMES_S), frame)


def transforms(*mounts: tuple[str, str, Rotation], topic: str = "/tf_static") -> Series:
    types = Types(2)

    def one(parent: str, child: str, turn: Rotation) -> Any:
        rotation = types.make("geometry_msgs/msg/Quaternion", vector(turn.as_quat(), "xyzw"))
        fields = {"transform": types.make("geometry_msgs/msg/Transform", {"rotation": rotation})}
        head = types.make("std_msgs/msg/Header", {"frame_id": parent})
        return types.make("geometry_msgs/msg/TransformStamped", {**fields, "header": head, "child_frame_id": child})

    messages = [{"transforms": [one(*mount)]} for mount in mounts]
    return Series(topic, TRANSFORMS, messages, stamps(np.arange(len(mounts)) * 0.1))


def flight_in(series: Sequence[Series], place: Path) -> tuple[dict[str, Array], tuple[str, ...]]:
    write_plain(place / "bag", series)
    table, contents = read(place / "bag")
    return table, contents.notes


def write_plain(path: Path, series: Sequence[Series]) -> None:
    """A bag whose transforms have no header of their own."""
    types = Types(2)
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        for one in series:
            connection = writer.add_connection(one.topic, one.kind, typestore=types.store)
            headed = any(name == "header" for name, _ in types.store.fielddefs[one.kind][1])
            for received, stamp, fields in one.received():
                if headed:
                    raw = types.stamped(one.kind, stamp, one.frame, fields)
                else:
                    raw = bytes(types.store.serialize_cdr(types.make(one.kind, fields), one.kind))
                writer.write(connection, received, raw)


ASKEW, ROLLED = Rotation.from_euler("ZYX", [90, 20, 180], degrees=True), Rotation.from_euler("x", 180, degrees=True)


def test_a_magnetometer_is_turned_by_its_mount(tmp_path: Path) -> None:
    series = [magnetic(ASKEW, "mag_link"), imu(Rotation.identity(), "base_link")]
    table, notes = flight_in([*series, transforms(("base_link", "mag_link", ASKEW))], tmp_path)
    assert_same_flight(table, 20.0)
    assert "mag_link: turned to base_link as the bag's transforms say" in notes
    assert not any("are taken as those of" in note for note in notes)


def test_a_chain_of_mounts_turns_imu_and_attitude_too(tmp_path: Path) -> None:
    series = [magnetic(ROLLED * ASKEW, "mag_link"), imu(ROLLED, "imu_link")]
    chain = transforms(("base_link", "imu_link", ROLLED), ("/imu_link", "/mag_link", ASKEW))
    assert_same_flight(flight_in([*series, chain], tmp_path)[0], 20.0)


def test_a_frame_that_moves_is_no_mount(tmp_path: Path) -> None:
    moving = transforms(("odom", "base_link", ASKEW), ("odom", "base_link", ROLLED), topic="/tf")
    series = [magnetic(Rotation.identity(), "base_link"), imu(Rotation.identity(), "base_link"), moving]
    assert_same_flight(flight_in(series, tmp_path)[0], 20.0)


@pytest.mark.parametrize("frame", ["base_link_frd", "imu_link"])
def test_axes_forward_right_down_are_turned(frame: str, tmp_path: Path) -> None:
    """By the frame's name, and without one since the attitude turns the specific force at rest down."""
    table, notes = flight_in([magnetic(FRD, frame), imu(FRD, frame, NED_Q)], tmp_path)
    assert_same_flight(table, 20.0)
    assert f"{frame}: axes forward, right, down turned to forward, left, up" in notes


def own(kind: str) -> Series:
    """Messages of a project's own types, in gauss, microtesla and microtesla."""
    field = FLIGHT.field_nT
    bodies = {
        "px4_msgs/msg/SensorMag": [vector(row) for row in 1e-5 * FRD.inv().apply(field)],
        "boat_msgs/msg/Nine": [
            {"mag_raw": 1e-3 * row, "mag_bias": np.ones(3) * k, "acc": np.ones(3) * k} for k, row in enumerate(field)
        ],
        "boat_msgs/msg/Compass": [{"field": vector(1e-3 * row)} for row in field],
    }
    topics = {"px4_msgs/msg/SensorMag": "/fmu/out/sensor_mag", "boat_msgs/msg/Nine": "/board"}
    return Series(topics.get(kind, "/compass"), kind, bodies[kind], stamps(TIMES_S))


@pytest.mark.parametrize("kind", [kind for kind in OWN if kind != TRANSFORMS])
def test_messages_of_own_types(kind: str, tmp_path: Path) -> None:
    table, _ = flight_in([own(kind)], tmp_path)
    field = np.column_stack([table[f"mag_{axis}_nT"] for axis in "xyz"])
    np.testing.assert_allclose(field, FLIGHT.field_nT, atol=0.02)
    assert not any("mag_raw" in name for name in table)


def parts_of(series: Series, first_s: float, last_s: float) -> Series:
    chosen = [k for k, t in enumerate(TIMES_S) if first_s <= t < last_s]
    return replace(series, messages=[series.messages[k] for k in chosen], stamp_ns=[series.stamp_ns[k] for k in chosen])


@pytest.mark.parametrize("ros", [1, 2])
def test_a_directory_of_bags_without_metadata(ros: int, tmp_path: Path) -> None:
    whole = [magnetic(Rotation.identity(), "base_link"), imu(Rotation.identity(), "base_link")]
    (tmp_path / "log").mkdir()
    for number, (first_s, last_s) in enumerate([(0, 3), (3, 6), (6, 9)]):
        part = tmp_path / f"part_{number}{'.bag' if ros == 1 else ''}"
        write_bag(part, [parts_of(one, first_s, last_s) for one in whole], ros)
        file = part if ros == 1 else next(part.glob("*.mcap"))
        shutil.copy(file, tmp_path / "log" / file.name)
    table, contents = read(tmp_path / "log")
    np.testing.assert_allclose(table["time_s"], TIMES_S, atol=1e-6)
    assert_same_flight(table, 20.0)
    assert "3 bags are read as the parts of one recording" in contents.notes


@pytest.mark.parametrize("mode", [CompressionMode.FILE, CompressionMode.MESSAGE])
def test_a_file_that_its_metadata_says_is_compressed(mode: CompressionMode, tmp_path: Path) -> None:
    types, one = Types(2), magnetic(Rotation.identity(), "base_link")
    writer = Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.SQLITE3)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection(one.topic, one.kind, typestore=types.store)
        for received, stamp, fields in one.received():
            writer.write(connection, received, types.stamped(one.kind, stamp, one.frame, fields))
    file = next(path for path in (tmp_path / "bag").iterdir() if path.suffix != ".yaml")
    np.testing.assert_allclose(read(file)[0]["mag_z_nT"], FLIGHT.field_nT[:, 2], atol=1e-3)
    (tmp_path / "bag" / "metadata.yaml").unlink()
    with pytest.raises(InputError, match=r"is compressed by zstd|holds no message"):
        load(file, lambda name: True)


def test_every_command_takes_a_directory(tmp_path: Path) -> None:
    """A bag of several files is no dataset of simulated runs."""
    series = [magnetic(Rotation.identity(), "base_link"), imu(Rotation.identity(), "base_link")]
    write_plain(tmp_path / "bag", series)
    found = magbench.inspect(tmp_path / "bag")
    assert found.log.origin.magnetometer == "/imu/mag"
    assert magbench.calibrate(tmp_path / "bag", FIELD_NT).status.kind == "ok"
    (source,) = file_sources([tmp_path / "bag"], None)
    assert source.name == "bag"
