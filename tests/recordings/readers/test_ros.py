"""ROS bags of a simulated flight: the field, the frames and the clock come back, whatever the storage."""

from __future__ import annotations

import datetime
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin

from recordings.readers import FileContents, load
from scenarios.arrays import Array
from scenarios.errors import InputError
from tests.recordings.readers.damage import DAMAGED_FILES
from tests.recordings.readers.flights import Flight, assert_same_flight
from tests.recordings.readers.ros_bags import Series, Types, vector, write_bag
from tests.recordings.readers.test_contract import assert_read_or_refused

START_NS = 1_714_564_800 * 10**9  # 2024-05-01 12:00 UTC
MAG_S = np.arange(0.0, 12.0, 0.04)
IMU_S = np.arange(-0.1, 12.2, 0.01)
SOFT_IRON = np.array([[1.06, 0.03, -0.02], [0.01, 0.95, 0.04], [-0.03, 0.02, 1.01]])
HARD_IRON_NT = np.array([2_500.0, -3_800.0, 1_200.0])
TYPES = Types(2)
STORAGES = ("ros1", "sqlite", "mcap", "bare mcap", "bare db3")


def ns(time_s: Array) -> list[int]:
    return [START_NS + round(1e9 * t) for t in time_s.tolist()]


def mag(flight: Flight, topic: str = "/imu/mag", **changes: Any) -> Series:
    measured = flight.field_nT @ SOFT_IRON.T + HARD_IRON_NT
    messages = [{"magnetic_field": vector(1e-9 * row)} for row in measured]
    given = {"messages": messages, "stamp_ns": ns(flight.time_s)} | changes
    return Series(topic, "sensor_msgs/msg/MagneticField", **given)


def imu(flight: Flight, topic: str = "/imu/data", *, attitude: bool = True) -> Series:
    unknown = np.zeros(9)
    unknown[0] = -1.0
    rows = zip(flight.q[:, [1, 2, 3, 0]], flight.rate_rad_s, flight.specific_force_m_s2, strict=True)
    messages = [
        {
            "orientation": vector(q, "xyzw") if attitude else vector((0, 0, 0, 1), "xyzw"),
            "orientation_covariance": np.full(9, 0.01) if attitude else unknown,
            "angular_velocity": vector(rate),
            "linear_acceleration": vector(force),
        }
        for q, rate, force in rows
    ]
    return Series(topic, "sensor_msgs/msg/Imu", messages, ns(flight.time_s))


def slow(topic: str, kind: str, messages: list[dict[str, Any]], rate_hz: float = 5.0) -> Series:
    times_s = np.arange(len(messages)) / rate_hz - 0.2
    return Series(topic, kind, messages, ns(times_s))


def everything() -> list[Series]:
    """A MAVROS flight: magnetometer at 25 Hz, IMU at 100 Hz, the others at 5 Hz."""
    k = range(64)
    fix = {"status": {"status": 0}, "latitude": 47.4, "longitude": 8.5}
    battery = [{"voltage": 12.5 - 0.01 * i, "current": -5.0 - 0.1 * i} for i in k]
    return [
        mag(Flight(MAG_S)),
        imu(Flight(IMU_S)),
        slow("/fix", "sensor_msgs/msg/NavSatFix", [fix | {"altitude": 500.0 + i} for i in k]),
        slow("/battery", "sensor_msgs/msg/BatteryState", battery),
        slow("/imu/temperature", "sensor_msgs/msg/Temperature", [{"temperature": 30 + 0.1 * i} for i in k]),
        slow(
            "/mavros/state",
            "mavros_msgs/msg/State",
            [{"armed": i > 9, "mode": "LOITER" if i < 30 else "RTL"} for i in k],
        ),
        slow("/mavros/vfr_hud", "mavros_msgs/msg/VfrHud", [{"throttle": 0.01 * i, "airspeed": 0.5 * i} for i in k]),
        slow("/odom", "nav_msgs/msg/Odometry", [{"pose": {"pose": {"position": vector((i, 2 * i, 3))}}} for i in k]),
    ]


def written(series: list[Series], place: Path, storage: str = "mcap") -> Path:
    """The path that a user would give."""
    if storage == "ros1":
        write_bag(place / "flight.bag", series, ros=1)
        return place / "flight.bag"
    plugin = StoragePlugin.MCAP if "mcap" in storage else StoragePlugin.SQLITE3
    write_bag(place / "flight", series, storage=plugin)
    return (
        next((place / "flight").glob("*.mcap" if "mcap" in storage else "*.db3"))
        if "bare" in storage
        else place / "flight"
    )


def read(path: Path, stream: str | None = None) -> tuple[dict[str, Array], FileContents]:
    contents = load(path, lambda name: True, stream)
    return {name: contents.table[name].to_numpy() for name in contents.table.column_names}, contents


@pytest.mark.parametrize("storage", STORAGES)
def test_flight_comes_back_from_every_storage(storage: str, tmp_path: Path) -> None:
    table, contents = read(written(everything(), tmp_path, storage))
    np.testing.assert_allclose(table["time_s"], MAG_S, atol=1e-6)
    field = np.column_stack([table[f"mag_{a}_nT"] for a in "xyz"])
    np.testing.assert_allclose(field, Flight(MAG_S).field_nT @ SOFT_IRON.T + HARD_IRON_NT, atol=1e-3)
    iron_free = np.linalg.solve(SOFT_IRON, (field - HARD_IRON_NT).T).T
    assert_same_flight(table | dict(zip(("mag_x_nT", "mag_y_nT", "mag_z_nT"), iron_free.T, strict=True)), 20.0)
    assert contents.place == pytest.approx((47.4, 8.5, 531.5))
    assert contents.date == datetime.date(2024, 5, 1)
    assert contents.frame == "flu"


def test_battery_modes_position_and_channels(tmp_path: Path) -> None:
    table, contents = read(written(everything(), tmp_path))
    at = (MAG_S + 0.2) * 5
    np.testing.assert_allclose(table["current_1_A"], 5.0 + 0.1 * at, atol=1e-5)
    np.testing.assert_allclose(table["battery_voltage_V"], 12.5 - 0.01 * at, atol=1e-5)
    np.testing.assert_allclose(table["temperature_degC"], 30 + 0.1 * at, atol=1e-5)
    np.testing.assert_allclose(table["pos_north_m"], 2 * at, atol=1e-5)
    np.testing.assert_allclose(table["throttle"], 0.01 * at, atol=1e-5)
    np.testing.assert_allclose(table["/mavros/vfr_hud.airspeed"], 0.5 * at, atol=1e-5)
    np.testing.assert_array_equal(table["phase"], np.where(at + 1e-6 < 30, "LOITER", "RTL"))
    np.testing.assert_array_equal(table["armed"], at + 1e-6 >= 10)
    assert not any("magnetic_field" in name or "covariance" in name for name in table)
    assert any("circular in yaw" in note for note in contents.notes)
    assert any("nothing is undone" in note for note in contents.notes)


def test_currents_of_motors_stand_before_the_batterys(tmp_path: Path) -> None:
    messages = [escs((1.0 + i, 3.0 + 2 * i)) for i in range(64)]
    series = [*everything(), slow("/mavros/esc_status", "mavros_msgs/msg/ESCStatus", messages)]
    table, _ = read(written(series, tmp_path))
    at = (MAG_S + 0.2) * 5
    np.testing.assert_allclose(table["current_1_A"], 1 + at, atol=1e-4)
    np.testing.assert_allclose(table["current_2_A"], 3 + 2 * at, atol=1e-4)
    np.testing.assert_allclose(table["/battery.current"], -5 - 0.1 * at, atol=1e-4)


def escs(currents_A: Sequence[float]) -> dict[str, Any]:
    return {"esc_status": [TYPES.make("mavros_msgs/msg/ESCStatusItem", {"current": one}) for one in currents_A]}


def test_several_magnetometers_by_topic(tmp_path: Path) -> None:
    second = mag(
        Flight(MAG_S[::2]), "/compass", messages=[{"magnetic_field": vector((1e-6 * k, 0, 0))} for k in range(150)]
    )
    path = written([second, mag(Flight(MAG_S))], tmp_path)
    assert read(path)[1].magnetometer == "/imu/mag"
    table, contents = read(path, "/compass")
    np.testing.assert_allclose(table["mag_x_nT"], 1e3 * np.arange(150), atol=1e-3)
    assert "--stream reads another: /imu/mag" in contents.notes[0]


def test_messages_without_a_stamp_are_dated_by_receipt(tmp_path: Path) -> None:
    """Receipt is 3 ms after the stamp for all, so that the magnetometer's lag places the unstamped IMU."""
    unstamped = imu(Flight(IMU_S))
    unstamped = Series(unstamped.topic, unstamped.kind, unstamped.messages, [-t for t in unstamped.stamp_ns])
    table, _ = read(written([mag(Flight(MAG_S)), unstamped], tmp_path))
    np.testing.assert_allclose(table["gyro_z_rad_s"], Flight(MAG_S).rate_rad_s[:, 2], atol=1e-4)


def test_an_imu_without_an_estimate_gives_no_attitude(tmp_path: Path) -> None:
    table, _ = read(written([mag(Flight(MAG_S)), imu(Flight(IMU_S), attitude=False)], tmp_path))
    assert "gyro_x_rad_s" in table
    assert "att_qw" not in table


def test_samples_without_an_axis_and_other_units(tmp_path: Path) -> None:
    flight = Flight(MAG_S)
    messages = [{"magnetic_field": vector(1e-3 * row)} for row in flight.field_nT]  # microtesla
    messages[5] = {"magnetic_field": vector((20.0, 3.0, np.nan))}
    table, contents = read(written([mag(flight, messages=messages)], tmp_path))
    assert len(table["time_s"]) == len(MAG_S) - 1
    np.testing.assert_allclose(table["mag_x_nT"][:5], flight.field_nT[:5, 0], atol=1e-3)
    assert any("1 samples without all three axes" in note for note in contents.notes)
    assert any("is not in tesla: taken as uT" in note for note in contents.notes)


def test_a_bag_without_a_magnetometer_lists_its_topics(tmp_path: Path) -> None:
    path = written([imu(Flight(IMU_S))], tmp_path)
    with pytest.raises(InputError, match=r"no message of sensor_msgs/MagneticField; it holds /imu/data"):
        read(path)


@DAMAGED_FILES
@pytest.mark.parametrize("storage", ["ros1", "bare mcap", "bare db3"])
def test_damaged_bags_are_read_in_part_or_refused(storage: str, files: int, tmp_path: Path) -> None:
    short = Flight(MAG_S[:60])
    path = written([mag(short), imu(Flight(IMU_S[:300]))], tmp_path, storage)
    whole, rng = np.frombuffer(path.read_bytes(), np.uint8), np.random.default_rng(3)
    for trial in range(files // 3):
        damaged = whole.copy()
        at = rng.integers(0, len(whole), 1 + trial % 7)
        damaged[at] = rng.integers(0, 256, len(at))
        path.write_bytes(damaged[: rng.integers(1, len(whole)) if trial % 3 == 0 else None].tobytes())
        assert_read_or_refused(path)
