"""Motion, power and place of PX4 logs: frames, units and names, from a simulated flight."""

from __future__ import annotations

import datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from ulog_bytes import TopicOf, UlogOf, xyz

from recordings.columns import ACCEL, ATTITUDE, GYRO, POSITION
from recordings.readers import FileContents, load
from tests.recordings.readers.px4_flight import FIELD_ENU, FRD_OF_FLU, NED_OF_ENU, Flight

FLIGHT = Flight()
FAST_S = 99.0 + np.arange(0, 22, 0.01)
SLOW_S = 99.0 + np.arange(0, 22, 0.2)
GPS_S = 99.0 + np.arange(0.0, 22.0)


def read(tmp_path: Path, *topics: TopicOf, **parameters: float) -> FileContents:
    """The log of the topics beside a magnetometer that measures the Earth's field alone."""
    mag = TopicOf("sensor_mag", FLIGHT.time_s, xyz(FLIGHT.field_nT @ FRD_OF_FLU / 1e5) | temperature())
    (tmp_path / "log.ulg").write_bytes(UlogOf([mag, *topics], parameters, release=(1, 15, 2)).bytes())
    return load(tmp_path / "log.ulg", lambda name: True)


def temperature() -> dict[str, Any]:
    return {"temperature": ("float", 30 + 0.1 * (FLIGHT.time_s - 100))}


def columns(contents: FileContents, *names: str) -> np.ndarray:
    return np.column_stack([contents.table[name].to_numpy() for name in names])


def combined() -> TopicOf:
    """Rate and specific force in FRD; the accelerometer's sample is 4 ms older."""
    force = FLIGHT.attitude(FAST_S - 0.004).apply([0.0, 0.0, 9.81], inverse=True)
    fields = {
        "gyro_rad": ("float", FLIGHT.rate_rad_s(FAST_S) @ FRD_OF_FLU),
        "accelerometer_timestamp_relative": ("int32_t", np.full(len(FAST_S), -4000)),
        "accelerometer_m_s2": ("float", force @ FRD_OF_FLU),
    }
    return TopicOf("sensor_combined", FAST_S, fields)


def attitude() -> TopicOf:
    """FRD to NED, scalar first, of either sign."""
    turned = Rotation.from_matrix(NED_OF_ENU @ FLIGHT.attitude(SLOW_S).as_matrix() @ FRD_OF_FLU)
    q = turned.as_quat()[:, [3, 0, 1, 2]] * np.where(np.arange(len(SLOW_S)) % 3, 1, -1)[:, None]
    return TopicOf("vehicle_attitude", SLOW_S, {"q": ("float", q)}, padding=4)


def gps(lat: np.ndarray, names: tuple[str, str, str], factor: tuple[float, float, float], kind: str) -> TopicOf:
    values = (lat, np.full(len(GPS_S), 8.5), 500 + 2 * (GPS_S - 99))
    scaled = [np.where(GPS_S < 101, 0, value / unit) for value, unit in zip(values, factor, strict=True)]
    fields: dict[str, Any] = {
        name: (kind, np.round(value).astype(int) if kind == "int32_t" else value)
        for name, value in zip(names, scaled, strict=True)
    }
    utc_us = np.where(GPS_S < 101, 0, 1_700_000_000_000_000 + np.round((GPS_S - 99) * 1e6)).astype(int)
    fields |= {"time_utc_usec": ("uint64_t", utc_us), "fix_type": ("uint8_t", np.where(GPS_S < 101, 0, 3))}
    return TopicOf("vehicle_gps_position" if kind == "int32_t" else "sensor_gps", GPS_S, fields)


def test_the_gyro_turns_the_field_the_right_way_and_it_points_down(tmp_path: Path) -> None:
    """dm/dt = -w x m for the Earth's field; level, it points down by z < 0."""
    contents = read(tmp_path, combined())
    m, rate = columns(contents, "mag_x_nT", "mag_y_nT", "mag_z_nT"), columns(contents, *GYRO)
    change = (m[2:] - m[:-2]) / 0.1
    error = change + np.cross(rate[1:-1], m[1:-1])
    assert np.sqrt(np.mean(error**2)) < 0.01 * np.sqrt(np.mean(change**2))
    up = columns(contents, *ACCEL)
    np.testing.assert_allclose(np.sum(up * m, axis=1) / 9.81, FIELD_ENU[2], atol=15)


def test_the_attitude_maps_the_body_field_to_the_enu_field(tmp_path: Path) -> None:
    contents = read(tmp_path, attitude())
    q = columns(contents, *ATTITUDE)
    found = Rotation.from_quat(q[:, [1, 2, 3, 0]]).apply(columns(contents, "mag_x_nT", "mag_y_nT", "mag_z_nT"))
    np.testing.assert_allclose(found[::4], np.tile(FIELD_ENU, (100, 1)), atol=0.1)  # at the attitude's own times
    np.testing.assert_allclose(found, np.tile(FIELD_ENU, (400, 1)), atol=200)
    assert any("heading comes from the magnetometer" in note for note in contents.notes)
    assert not any("heading comes from" in note for note in read(tmp_path, attitude(), EKF2_MAG_TYPE=5).notes)


def test_the_local_position_becomes_east_north_up(tmp_path: Path) -> None:
    t = SLOW_S - 99
    valid = {name: ("bool", (SLOW_S > 100.9).astype(int)) for name in ("xy_valid", "z_valid")}
    local = TopicOf("vehicle_local_position", SLOW_S, xyz(np.column_stack([2 * t, 3 * t, -t])) | valid)
    contents = read(tmp_path, local)
    t = contents.table["time_s"].to_numpy() - 99
    assert t[0] > 1.9
    np.testing.assert_allclose(columns(contents, *POSITION), np.column_stack([3 * t, 2 * t, t]), atol=1e-4)


@pytest.mark.parametrize(
    ("names", "factor", "kind"),
    [
        (("lat", "lon", "alt_ellipsoid"), (1e-7, 1e-7, 1e-3), "int32_t"),
        (("latitude_deg", "longitude_deg", "altitude_ellipsoid_m"), (1.0, 1.0, 1.0), "double"),
    ],
    ids=["until v1.14", "since v1.15"],
)
def test_place_and_date_of_the_gps(
    names: tuple[str, str, str], factor: tuple[float, float, float], kind: str, tmp_path: Path
) -> None:
    """Rows without a fix are zero and do not count; 1e-5 degrees of latitude are 1.11 m."""
    topic = gps(47.0 + 1e-5 * (GPS_S - 101), names, factor, kind)
    if kind == "int32_t":
        topic.fields = {**topic.fields, "alt": topic.fields["alt_ellipsoid"]}
    contents = read(tmp_path, topic)
    assert contents.place == pytest.approx((47.000095, 8.5, 523.0), abs=1e-6)
    assert contents.date == datetime.date(2023, 11, 14)
    assert contents.start_s == pytest.approx(1_700_000_000 - 99, abs=1e-3)
    assert "position from GPS, relative to the first fix" in contents.notes
    t = contents.table["time_s"].to_numpy()
    np.testing.assert_allclose(contents.table["latitude_deg"].to_numpy(), 47.0 + 1e-5 * (t - 101), atol=1e-7)
    expected = np.column_stack([0 * t, 1.112 * (t - 101), 2 * (t - 101)])
    np.testing.assert_allclose(columns(contents, *POSITION), expected, atol=0.02)


def test_modes_become_phases_that_last_until_the_next(tmp_path: Path) -> None:
    status = TopicOf("vehicle_status", [99.0, 104.01, 111.01], {"nav_state": ("uint8_t", [0, 4, 99])})
    contents = read(tmp_path, status)
    phase, t = contents.table["phase"].to_numpy(zero_copy_only=False), contents.table["time_s"].to_numpy()
    np.testing.assert_array_equal(phase, np.select([t < 104.01, t < 111.01], ["manual", "hold"], "mode 99"))


def test_power_of_a_newer_log(tmp_path: Path) -> None:
    """Motors 1 and 2 of twelve; speed controllers of which the third measures no current."""
    s = np.sin(FAST_S)
    control = np.full((len(FAST_S), 12), np.nan)
    control[:, :2] = np.column_stack([0.5 + 0.1 * s, 0.4 - 0.1 * s])
    thrust = np.column_stack([0 * s, 0.6 * (0.5 + 0.1 * s), -0.8 * (0.5 + 0.1 * s)])
    escs = {f"esc[{k}].esc_current": ("float", (10 + k + s) if k < 2 else 0 * s) for k in range(3)}
    contents = read(
        tmp_path,
        TopicOf("actuator_motors", FAST_S, {"control": ("float", control)}),
        TopicOf("vehicle_thrust_setpoint", FAST_S, {"xyz": ("float", thrust)}),
        TopicOf("esc_status", FAST_S, {"esc_count": ("uint8_t", np.full(len(s), 3))} | escs),
        TopicOf("battery_status", FAST_S, {"voltage_v": ("float", 15 - s), "current_a": ("float", 20 + s)}),
        TopicOf("vehicle_status", GPS_S, {"arming_state": ("uint8_t", np.where(GPS_S < 105, 1, 2))}),
    )
    t = contents.table["time_s"].to_numpy()
    s = np.sin(t)
    expected = {"motor_output_1": 0.5 + 0.1 * s, "motor_output_2": 0.4 - 0.1 * s, "throttle": 0.5 + 0.1 * s}
    expected |= {"current_1_A": 10 + s, "current_2_A": 11 + s, "battery_voltage_V": 15 - s}
    expected |= {"armed": t >= 105, "battery_status.current_a": 20 + s, "temperature_degC": 30 + 0.1 * (t - 100)}
    for name, values in expected.items():
        np.testing.assert_allclose(contents.table[name].to_numpy(), values, atol=1e-4, err_msg=name)
    assert not {"current_3_A", "motor_output_3"} & set(contents.table.column_names)
    assert "PX4 1.15.2" in contents.notes


def test_power_of_an_older_log(tmp_path: Path) -> None:
    """Pulses of PWM_MIN to PWM_MAX are motors of a rotary-wing vehicle; the battery's current stands for theirs."""
    s = np.sin(FAST_S)
    pulses = np.column_stack([1475 + 300 * s, np.full(len(s), 0.0)])
    outputs = TopicOf("actuator_outputs", FAST_S, {"output": ("float", pulses)})
    battery = TopicOf("battery_status", FAST_S, {"voltage_v": ("float", 15 - s), "current_a": ("float", 20 + s)})
    rotary = TopicOf("vehicle_status", GPS_S, {"is_rotary_wing": ("bool", np.ones(len(GPS_S), int))})
    contents = read(tmp_path, outputs, battery, rotary, PWM_MIN=1000, PWM_MAX=1950)
    s = np.sin(contents.table["time_s"].to_numpy())
    np.testing.assert_allclose(contents.table["motor_output_1"].to_numpy(), (475 + 300 * s) / 950, atol=1e-4)
    np.testing.assert_allclose(contents.table["current_1_A"].to_numpy(), 20 + s, atol=1e-3)
    assert any("current_1_A is the battery's current" in note for note in contents.notes)
    assert "battery_status.current_a" not in contents.table.column_names
    without = read(tmp_path, outputs, battery)
    assert "motor_output_1" not in without.table.column_names
    assert "actuator_outputs.output[0]" in without.table.column_names


def test_every_other_number_is_a_channel_under_its_own_name(tmp_path: Path) -> None:
    real, whole = 5 * np.sin(SLOW_S), np.arange(len(SLOW_S)) // 10
    wind = TopicOf("wind", SLOW_S, {"windspeed": ("float", np.column_stack([real, 0 * real]))})
    turn = TopicOf("trajectory_setpoint", SLOW_S, {"yaw": ("float", (SLOW_S + np.pi) % (2 * np.pi) - np.pi)})
    flags = TopicOf("telemetry_status", SLOW_S, {"rxerrors": ("uint32_t", whole)}, instance=1)
    contents = read(tmp_path, wind, turn, flags)
    names = contents.table.column_names
    assert {"wind.windspeed[0]", "telemetry_status[1].rxerrors"} <= set(names)
    assert "wind.windspeed[1]" not in names
    errors = contents.table["telemetry_status[1].rxerrors"].to_numpy()
    np.testing.assert_array_equal(errors, np.floor(errors))
    yaw = contents.table["trajectory_setpoint.yaw"].to_numpy() - contents.table["time_s"].to_numpy()
    np.testing.assert_allclose(np.cos(yaw), 1, atol=1e-9)


def test_channels_beyond_the_limit_are_left_out_and_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The topics that may disturb a magnetometer come first."""
    monkeypatch.setattr("recordings.readers.px4.channels.MOST_CHANNELS", 3)
    values = np.sin(SLOW_S)[:, None] * np.arange(1, 4)
    topics = [TopicOf(name, SLOW_S, {"x": ("float", values)}) for name in ("estimator_states", "system_power")]
    contents = read(tmp_path, *topics)
    assert "system_power.x[2]" in contents.table.column_names
    assert "estimator_states.x[0]" not in contents.table.column_names
    assert any(note.startswith("3 of 6 channels left out") for note in contents.notes)
