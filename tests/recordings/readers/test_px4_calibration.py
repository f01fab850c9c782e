"""The field that a magnetometer measured, from logs of each age of PX4, with real calibrations in force."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from ulog_bytes import TopicOf, UlogOf, xyz

from recordings.columns import mag_names
from recordings.readers import FileContents, load
from tests.recordings.readers.px4_flight import Calibration, Flight, vehicle_magnetometer

DEVICE = 396809
"""A sensor on an I2C bus."""
RESOLUTION_NT = 0.05
"""Half a step of a float of 4 bytes, some 1 G, through the calibration and back."""
FLIGHT = Flight()
CAL = Calibration((0.12, -0.27, 0.081), (1.06, 0.93, 1.02), (0.031, -0.024, 0.017), (0.08, -0.05, 0.11))
IN_AMPERES = replace(CAL, power=(4.0, -2.5, 6.0))
LEVEL = {"SENS_BOARD_X_OFF": 1.5, "SENS_BOARD_Y_OFF": -2.5, "SENS_BOARD_Z_OFF": 4.0}
LEVELLED = Rotation.from_euler("ZYX", [4.0, -2.5, 1.5], degrees=True)
ROLL_180_YAW_90 = Rotation.from_matrix([[0, 1, 0], [1, 0, 0], [0, 0, -1]])
"""Mounting 10: the sensor's x points right, its y forward, its z up."""
YAW_180 = Rotation.from_matrix(np.diag([-1, -1, 1]))
"""Mounting 4."""
NO_POWER = np.zeros(400)
ARMED = (FLIGHT.time_s > 105).astype(int)


def read(tmp_path: Path, log: UlogOf, stream: str | None = None) -> FileContents:
    (tmp_path / "log.ulg").write_bytes(log.bytes())
    return load(tmp_path / "log.ulg", lambda name: True, stream)


def field_of(contents: FileContents) -> np.ndarray:
    return np.column_stack([contents.table[name].to_numpy() for name in mag_names()])


def assert_measured(contents: FileContents, rows: slice = slice(None), within_nT: float = RESOLUTION_NT) -> None:
    np.testing.assert_allclose(contents.table["time_s"].to_numpy(), FLIGHT.time_s[rows], atol=1e-6)
    np.testing.assert_allclose(field_of(contents), FLIGHT.measured_nT[rows], atol=within_nT)


def sensor_mag(x: np.ndarray, every: int = 1, device: int = DEVICE, instance: int = 0) -> TopicOf:
    number = {"device_id": ("uint32_t", np.full(len(x[::every]), device))}
    return TopicOf("sensor_mag", FLIGHT.time_s[::every], number | xyz(x[::every]), instance)


def power_topics(*, controls: bool) -> list[TopicOf]:
    """Throttle and battery current at the magnetometer's times, armed from 105 s on; the throttle's topic by age."""
    thrust = np.column_stack([0.3 * FLIGHT.throttle, np.zeros(400), -np.sqrt(0.91) * FLIGHT.throttle])
    setpoint = TopicOf("vehicle_thrust_setpoint", FLIGHT.time_s, {"xyz": ("float", thrust * (0.5 if controls else 1))})
    control = np.column_stack([np.zeros((400, 3)), FLIGHT.throttle])
    battery = {"voltage_v": ("float", 15 + 0 * FLIGHT.time_s), "current_a": ("float", FLIGHT.current_A)}
    own = [TopicOf("actuator_controls_0", FLIGHT.time_s, {"control": ("float", control)})] if controls else []
    return [
        *own,
        setpoint,
        TopicOf("battery_status", FLIGHT.time_s, battery),
        TopicOf("actuator_armed", FLIGHT.time_s, {"armed": ("bool", ARMED)}),
    ]


def test_a_raw_sensor_is_turned_into_the_body_and_left_as_it_is(tmp_path: Path) -> None:
    mounting = LEVELLED * ROLL_180_YAW_90
    x = FLIGHT.sensor_G(mounting)
    body = vehicle_magnetometer(FLIGHT, CAL.newest(x, NO_POWER, mounting), DEVICE)
    contents = read(tmp_path, UlogOf([sensor_mag(x), body], CAL.parameters(2, DEVICE, 10) | LEVEL))
    assert_measured(contents)
    assert contents.magnetometer == "2"
    assert any("sensor_mag is raw: nothing to undo" in note for note in contents.notes)
    applied = contents.applied["2"]
    assert not applied.undone
    in_force = (field_of(contents) - applied.offset_nT) @ applied.matrix.T
    np.testing.assert_allclose(in_force * [1, -1, -1] / 1e5, CAL.newest(x, NO_POWER, mounting), atol=1e-6)
    assert applied.parameters["CAL_MAG2_YODIAG"] == pytest.approx(-0.024)
    assert {"CAL_MAG2_ID", "CAL_MAG2_ROT", "SENS_BOARD_X_OFF"} <= applied.parameters.keys()


@pytest.mark.parametrize("sparse", [True, False], ids=["beside sparse sensor_mag", "alone"])
@pytest.mark.parametrize("kind", [0, 1, 2])
def test_the_newest_formula_is_undone(kind: int, sparse: bool, tmp_path: Path) -> None:
    """Custom mounting, off-diagonals, levelled, with power by throttle while armed or by current in kA."""
    calibration = IN_AMPERES if kind == 2 else CAL
    power = {0: NO_POWER, 1: FLIGHT.throttle * ARMED, 2: FLIGHT.current_A * 1e-3}[kind]
    mounting = LEVELLED * Rotation.from_euler("ZYX", [70, -20, 15], degrees=True)
    x = FLIGHT.sensor_G(mounting)
    parameters = calibration.parameters(0, DEVICE, 100) | LEVEL | {"CAL_MAG_COMP_TYP": kind}
    parameters |= {"CAL_MAG0_ROLL": 15.0, "CAL_MAG0_PITCH": -20.0, "CAL_MAG0_YAW": 70.0}
    topics = [
        vehicle_magnetometer(FLIGHT, calibration.newest(x, power, mounting), DEVICE),
        *power_topics(controls=False),
    ]
    contents = read(tmp_path, UlogOf([*topics, *([sensor_mag(x, 20)] if sparse else [])], parameters))
    assert_measured(contents)
    note = next(note for note in contents.notes if "undone in the body frame" in note)
    assert "CAL_MAG0_XOFF 0.12" in note
    assert ("power compensation" in note) == bool(kind)
    assert contents.applied["0"].undone


def test_the_throttle_of_releases_with_actuator_controls(tmp_path: Path) -> None:
    mounting = Rotation.identity()
    x = FLIGHT.sensor_G(mounting)
    body = CAL.newest(x, FLIGHT.throttle * ARMED, mounting)
    parameters = CAL.parameters(0, DEVICE, 0) | {"CAL_MAG_COMP_TYP": 1}
    topics = [vehicle_magnetometer(FLIGHT, body, DEVICE), *power_topics(controls=True)]
    assert_measured(read(tmp_path, UlogOf(topics, parameters)))
    lacking = read(tmp_path, UlogOf([topics[0], topics[-1]], parameters))
    assert any("lacks the signal of the power compensation" in note for note in lacking.notes)


def test_the_bias_estimate_before_takeoff_is_undone(tmp_path: Path) -> None:
    """Valid from 103 s on; a change of the calibration at 112 s sets PX4's bias back to zero."""
    mounting, values = YAW_180, np.array([0.04, -0.03, 0.02])
    x, t = FLIGHT.sensor_G(mounting), FLIGHT.time_s
    later = replace(CAL, offset=(0.2, -0.2, 0.0))
    bias = np.where(((t >= 103) & (t < 112))[:, None], values, 0.0)
    before, after = (one.newest(x, NO_POWER, mounting, bias) for one in (CAL, later))
    body = np.where((t > 112)[:, None], after, before)
    estimate_s = np.arange(101.0, 111.0)
    estimates = {
        f"bias_{axis}": ("float", np.column_stack([np.full((10, 1), 9.0), np.full((10, 1), value)]))
        for axis, value in zip("xyz", values, strict=True)
    }
    valid = np.column_stack([np.ones(10, int), estimate_s >= 103])
    topics = [
        vehicle_magnetometer(FLIGHT, body, DEVICE),
        sensor_mag(x, 40, instance=1),
        TopicOf("magnetometer_bias_estimate", estimate_s, estimates | {"valid": ("bool", valid)}),
    ]
    changes = [(112.02, f"CAL_MAG0_{axis}OFF", value) for axis, value in zip("XYZ", later.offset, strict=True)]
    contents = read(tmp_path, UlogOf(topics, CAL.parameters(0, DEVICE, -1) | {"SENS_BOARD_ROT": 4}, changes))
    rows = np.abs(t - 112) > 0.06
    np.testing.assert_allclose(field_of(contents)[rows], FLIGHT.measured_nT[rows], atol=RESOLUTION_NT)
    assert "magnetometer_bias_estimate undone" in contents.notes
    assert any("changed 1 times within the log" in note for note in contents.notes)


@pytest.mark.parametrize(
    ("small", "ignored"),
    [
        (Calibration((0.005, -0.006, 0.004)), True),
        (Calibration((0.006, -0.007, 0.006)), False),
        (Calibration(scale=(1.006, 0.994, 1.004)), True),
        (Calibration(scale=(1.007, 0.993, 1.006)), False),
        (Calibration(off_diagonal=(0.006, 0.006, 0.004)), True),
        (Calibration(off_diagonal=(0.006, 0.006, 0.007)), False),
    ],
)
def test_px4_ignores_values_within_a_hundredth(small: Calibration, ignored: bool, tmp_path: Path) -> None:
    x = FLIGHT.sensor_G(Rotation.identity())
    in_force = Calibration() if ignored else small
    body = vehicle_magnetometer(FLIGHT, in_force.newest(x, NO_POWER, Rotation.identity()), DEVICE)
    contents = read(tmp_path, UlogOf([body], small.parameters(0, DEVICE, 0)))
    assert_measured(contents)
    assert any("no calibration in force" in note for note in contents.notes) == ignored


def test_a_small_change_within_the_log_is_ignored_and_a_large_one_is_not(tmp_path: Path) -> None:
    x, t = FLIGHT.sensor_G(Rotation.identity()), FLIGHT.time_s
    large = replace(CAL, offset=(0.15, -0.27, 0.081))
    body = np.where((t > 114)[:, None], *(one.newest(x, NO_POWER, Rotation.identity()) for one in (large, CAL)))
    changes = [(107.02, "CAL_MAG0_XOFF", 0.125), (114.02, "CAL_MAG0_XOFF", 0.15)]
    log = UlogOf([vehicle_magnetometer(FLIGHT, body, DEVICE)], CAL.parameters(0, DEVICE, 0), changes)
    rows = np.abs(t - 114) > 0.06
    np.testing.assert_allclose(field_of(read(tmp_path, log))[rows], FLIGHT.measured_nT[rows], atol=RESOLUTION_NT)


@pytest.mark.parametrize("kind", [0, 1, 2])
def test_the_calibration_of_the_driver_is_undone(kind: int, tmp_path: Path) -> None:
    """v1.11: scale and offset in the driver, then power while armed, then the rotation; no device number."""
    calibration = replace(IN_AMPERES if kind == 2 else CAL, off_diagonal=(0.0, 0.0, 0.0))
    power = {0: NO_POWER, 1: FLIGHT.throttle, 2: FLIGHT.current_A * 1e-3}[kind] * ARMED
    mounting = LEVELLED * YAW_180
    x = FLIGHT.sensor_G(mounting)
    parameters = calibration.parameters(1, DEVICE, -1, new=False) | LEVEL | {"SENS_BOARD_ROT": 4}
    parameters |= {"CAL_MAG_PRIME": DEVICE, "CAL_MAG_COMP_TYP": kind}
    body = vehicle_magnetometer(FLIGHT, calibration.older(x, power, mounting), None)
    contents = read(tmp_path, UlogOf([body, *power_topics(controls=True)], parameters))
    assert_measured(contents)
    assert contents.magnetometer == "1"
    sensor = sensor_mag(calibration.driver(x))
    assert_measured(read(tmp_path, UlogOf([sensor, body, *power_topics(controls=True)], parameters)))


def test_external_sensors_of_the_driver_are_not_levelled(tmp_path: Path) -> None:
    x = FLIGHT.sensor_G(ROLL_180_YAW_90)
    calibration = Calibration(CAL.offset, CAL.scale)
    body = vehicle_magnetometer(FLIGHT, calibration.older(x, NO_POWER, ROLL_180_YAW_90), None)
    parameters = calibration.parameters(0, DEVICE, 10, new=False) | LEVEL | {"CAL_MAG_PRIME": DEVICE}
    assert_measured(read(tmp_path, UlogOf([body], parameters)))


def test_the_oldest_logs_hold_the_field_in_sensor_combined(tmp_path: Path) -> None:
    """Rows at 100 Hz repeat the magnetometer's sample of 20 Hz, whose time is relative."""
    x = FLIGHT.sensor_G(YAW_180)
    calibration = Calibration(CAL.offset, CAL.scale)
    row_s = 100.0 + np.arange(0, 20, 0.01)
    sample = np.minimum(((row_s - 100.0) / 0.05 + 1e-6).astype(int), 399)
    relative_us = np.round((FLIGHT.time_s[sample] - row_s) * 1e6).astype(int)
    fields = {"magnetometer_timestamp_relative": ("int32_t", relative_us)}
    fields |= {"magnetometer_ga": ("float", calibration.older(x, NO_POWER, YAW_180)[sample])}
    parameters = calibration.parameters(0, 262144, -1, new=False) | {"SENS_BOARD_ROT": 4, "CAL_MAG_PRIME": 262144}
    del parameters["CAL_MAG0_EN"]
    combined = TopicOf("sensor_combined", row_s, fields)
    assert_measured(read(tmp_path, UlogOf([combined], parameters)))
    assert_measured(read(tmp_path, UlogOf([combined, sensor_mag(calibration.driver(x), 20, 262144)], parameters)))


def test_the_samples_tell_the_formula_where_the_parameters_do_not(tmp_path: Path) -> None:
    """v1.12 has the parameters of v1.13 and does not level external sensors."""
    x = FLIGHT.sensor_G(ROLL_180_YAW_90)
    body = CAL.newest(x, NO_POWER, ROLL_180_YAW_90)
    topics = [vehicle_magnetometer(FLIGHT, body, DEVICE), sensor_mag(x, 20)]
    steep = {name: 4 * angle for name, angle in LEVEL.items()}
    assert_measured(read(tmp_path, UlogOf(topics, CAL.parameters(0, DEVICE, 10) | steep)))


def test_several_magnetometers_have_their_own_calibration(tmp_path: Path) -> None:
    other = Calibration((-0.2, 0.1, 0.3), (0.9, 1.1, 1.05), (0.02, 0.02, -0.03))
    mounting = Rotation.identity()
    x = FLIGHT.sensor_G(mounting)
    bodies = [
        vehicle_magnetometer(FLIGHT, CAL.newest(x, NO_POWER, mounting), DEVICE),
        replace(vehicle_magnetometer(FLIGHT, other.newest(x, NO_POWER, mounting), 590114, every=2), instance=1),
    ]
    log = UlogOf(bodies, other.parameters(0, 590114, 0) | CAL.parameters(1, DEVICE, 0))
    contents = read(tmp_path, log)
    assert_measured(contents)
    assert contents.magnetometer == "1"
    second = read(tmp_path, log, "0")
    assert_measured(second, slice(None, None, 2))
    np.testing.assert_allclose(second.applied["0"].offset_nT, [-20_000, -10_000, -30_000], rtol=1e-6)


def test_a_magnetometer_without_parameters_goes_by_its_number(tmp_path: Path) -> None:
    x = FLIGHT.sensor_G(Rotation.identity())
    contents = read(tmp_path, UlogOf([sensor_mag(x)], {"CAL_MAG0_ID": 0, "CAL_MAG0_PRIO": 50}))
    assert_measured(contents)
    assert contents.magnetometer == str(DEVICE)
    assert any("no CAL_MAGn_ID" in note for note in contents.notes)
