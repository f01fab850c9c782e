"""Telemetry logs as links bring them: each sensor's field comes back from ArduPilot's and PX4's messages."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from dataflash_bytes import DOWN

from recordings.readers import load
from recordings.readers.base import FileContents
from scenarios.arrays import Array
from tests.recordings.readers.dataflash import START_S, flight
from tests.recordings.readers.telemetry import Telemetry
from tests.recordings.readers.test_tlog import IRON_NT, MATRIX, MOTOR_MG_A, OFFSET_MG, STEP_NT

ONE = flight(200)
OTHER_MG = np.array([35.0, -150.2, 88.8])
RAW_NT = ONE.field_nT + IRON_NT
RAW_MG = RAW_NT * DOWN / 100
COPTER, ARDUPILOT, PX4 = 2, 3, 12


def send_parameters(log: Telemetry, time_s: float, values: dict[str, float], sender: tuple[int, int] = (1, 1)) -> None:
    for name, value in values.items():
        log.add("PARAM_VALUE", time_s, value, len(values), 0, name.encode(), 9, sender=sender)


def own(offset_mG: Array, suffix: str = "", **more: float) -> dict[str, float]:
    """A compass's parameters."""
    found = {f"COMPASS_OFS{suffix}_{axis}": float(x) for axis, x in zip("XYZ", offset_mG, strict=True)}
    found |= {f"COMPASS_DIA{suffix}_{axis}": float(x) for axis, x in zip("XYZ", np.diag(MATRIX), strict=True)}
    pairs = {"X": MATRIX[0, 1], "Y": MATRIX[0, 2], "Z": MATRIX[1, 2]}
    return found | {f"COMPASS_ODI{suffix}_{axis}": float(x) for axis, x in pairs.items()} | more


def send_compass(log: Telemetry, name: str, field_mG: Array, sender: tuple[int, int] = (1, 1)) -> None:
    """A whole mG a row; RAW_IMU has us, the others ms."""
    for t, row in zip(ONE.time_s.tolist(), np.trunc(field_mG), strict=True):
        tail = (0, 0) if name == "RAW_IMU" else (0,)
        log.add(name, t, t * (1e6 if name == "RAW_IMU" else 1e3), *[0] * 6, *row, *tail, sender=sender)


def beat(log: Telemetry, autopilot: int, sender: tuple[int, int] = (1, 1), kind: int = COPTER) -> None:
    for t in ONE.time_s[::10].tolist():
        log.add("HEARTBEAT", t, 5, kind, autopilot, 128, 4, 3, sender=sender)


def read(log: Telemetry, tmp_path: Path, stream: str | None = None) -> FileContents:
    return load(log.write(tmp_path / "flight.tlog"), lambda name: True, stream)


def field_of(contents: FileContents) -> Array:
    return np.column_stack([contents.table[f"mag_{axis}_nT"].to_numpy() for axis in "xyz"])


def test_parameters_that_change_on_the_way(tmp_path: Path) -> None:
    """Offsets at 8 s; a parameter that was sent twice alike changes nothing."""
    log, later = Telemetry(), ONE.time_s > START_S + 8.03
    offset = np.where(later[:, None], OTHER_MG, OFFSET_MG)
    send_compass(log, "RAW_IMU", (RAW_MG + offset) @ MATRIX.T)
    beat(log, ARDUPILOT)
    send_parameters(log, START_S + 2, own(OFFSET_MG))
    send_parameters(log, START_S + 4, own(OFFSET_MG))
    send_parameters(log, START_S + 8.03, own(OTHER_MG))
    contents = read(log, tmp_path)
    np.testing.assert_allclose(field_of(contents), RAW_NT, atol=STEP_NT)
    assert any("its calibration changed in the log" in note for note in contents.notes)
    np.testing.assert_allclose(contents.applied["1"].offset_nT * DOWN, -100 * OTHER_MG, rtol=1e-6)


def test_signed_frames_of_a_link_with_a_gimbal_a_station_and_another_vehicle(tmp_path: Path) -> None:
    """The autopilot's field is read, though the gimbal of the same system sends more of its own."""
    log = Telemetry(signed=True)
    send_compass(log, "RAW_IMU", (RAW_MG + OFFSET_MG) @ MATRIX.T)
    for name in ("RAW_IMU", "SCALED_IMU2", "SCALED_IMU3"):
        send_compass(log, name, 0.5 * RAW_MG, sender=(1, 154))
    send_parameters(log, START_S + 2, own(OFFSET_MG))
    send_parameters(log, START_S + 3, own(OTHER_MG), sender=(1, 154))
    send_parameters(log, START_S + 3, own(OTHER_MG), sender=(255, 190))
    beat(log, ARDUPILOT)
    beat(log, 8, sender=(255, 190), kind=6)
    contents = read(log, tmp_path)
    np.testing.assert_allclose(field_of(contents), RAW_NT, atol=STEP_NT)
    assert any("sender 1.1 is read, not 1.154" in note for note in contents.notes)


def test_three_compasses_without_a_heartbeat(tmp_path: Path) -> None:
    """The parameters name the autopilot; COMPASS_USE 0 puts the first place last; some parameters are lacking."""
    log = Telemetry()
    for name, factor in (("SCALED_IMU", 1.0), ("SCALED_IMU2", 0.9), ("SCALED_IMU3", 1.1)):
        send_compass(log, name, (factor * RAW_MG + OFFSET_MG) @ MATRIX.T)
    for suffix in ("", "2", "3"):
        send_parameters(log, START_S + 1, own(OFFSET_MG, suffix, COMPASS_USE=0))
    log.add("PARAM_VALUE", START_S + 1, 0.0, 900, 7, b"SYSID_THISMAV", 9)
    for name, factor in (("1", 1.0), ("2", 0.9), ("3", 1.1)):
        contents = read(log, tmp_path, name)
        np.testing.assert_allclose(field_of(contents), factor * RAW_NT, atol=STEP_NT)
    contents = read(log, tmp_path)
    assert contents.magnetometer == "2"
    assert any("of the autopilot's 900 parameters" in note for note in contents.notes)


@pytest.mark.parametrize(("text", "first"), [(b"ArduCopter V3.4.6 (e707341b)", True), (b"ArduCopter V4.4.0", False)])
def test_the_motors_term_by_the_release(text: bytes, first: bool, tmp_path: Path) -> None:
    log, motor = Telemetry(), ONE.current_A[:, None] * MOTOR_MG_A
    within = RAW_MG + OFFSET_MG + (motor if first else 0)
    send_compass(log, "RAW_IMU", within @ MATRIX.T + (0 if first else motor))
    beat(log, ARDUPILOT)
    for t, current_A in zip(ONE.time_s.tolist(), ONE.current_A.tolist(), strict=True):
        log.add("SYS_STATUS", t, *[0] * 4, 15_400, 100 * current_A, 0, 0, 0, 0, 0, 0, 80)
    log.add("STATUSTEXT", START_S + 1, 6, text)
    gains = {f"COMPASS_MOT_{axis}": float(x) for axis, x in zip("XYZ", MOTOR_MG_A, strict=True)}
    send_parameters(log, START_S + 2, own(OFFSET_MG, COMPASS_MOTCT=2) | gains)
    np.testing.assert_allclose(field_of(read(log, tmp_path)), RAW_NT, atol=2 * STEP_NT)


def test_a_restart_of_the_autopilot_loses_no_sample(tmp_path: Path) -> None:
    """At 12 s the autopilot's clock begins anew: the arrival tells the times."""
    log = Telemetry()
    for k, (t, row) in enumerate(zip(ONE.time_s.tolist(), np.trunc(RAW_MG), strict=True)):
        log.add("RAW_IMU", t, (t if k < 120 else t - START_S - 12.0) * 1e6, *[0] * 6, *row, 0, 0)
        log.add("ATTITUDE", t, (t if k < 120 else t - START_S - 12.0) * 1e3, *[0.0] * 6)
    contents = read(log, tmp_path)
    np.testing.assert_allclose(field_of(contents), RAW_NT, atol=STEP_NT)
    np.testing.assert_allclose(contents.table["time_s"].to_numpy(), ONE.time_s, atol=0.05)


def whole(number: int) -> float:
    """A whole number as PX4 sends it: its bits as those of a real number."""
    return float(struct.unpack("<f", struct.pack("<i", number))[0])


def send_px4(log: Telemetry, time_s: float, reals: dict[str, float], wholes: dict[str, int]) -> None:
    for name, value in reals.items():
        log.add("PARAM_VALUE", time_s, value, 60, 0, name.encode(), 9)
    for name, number in wholes.items():
        log.add("PARAM_VALUE", time_s, whole(number), 60, 0, name.encode(), 6)


def px4_reals(offset_G: Array, slot: int) -> dict[str, float]:
    scale = {"XSCALE": 1.07, "YSCALE": 0.94, "ZSCALE": 1.02, "XODIAG": 0.04, "YODIAG": -0.03, "ZODIAG": 0.05}
    found = {f"CAL_MAG{slot}_{axis}OFF": float(x) for axis, x in zip("XYZ", offset_G, strict=True)}
    return found | {f"CAL_MAG{slot}_{name}": value for name, value in scale.items()}


SCALE = np.array([[1.07, 0.04, -0.03], [0.04, 0.94, 0.05], [-0.03, 0.05, 1.02]])
YAW_90 = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def test_px4s_field_in_gauss_with_its_calibration_undone(tmp_path: Path) -> None:
    """Two sensors, the second of higher priority, mounted at a yaw of 90 degrees; its offset changes at 10 s."""
    log, later = Telemetry(), ONE.time_s > START_S + 10.03
    first, second = np.array([0.21, -0.14, 0.05]), np.array([0.11, -0.1, 0.3])
    offset = np.where(later[:, None], second, first)
    body = (((RAW_MG / 1000) @ YAW_90 - offset) @ SCALE.T) @ YAW_90.T
    for t, row in zip(ONE.time_s.tolist(), body, strict=True):
        log.add("HIGHRES_IMU", t, t * 1e6, *[0.0] * 6, *row, 0, 0, 0, 25.0, 0, 0)
    beat(log, PX4)
    wholes = {"CAL_MAG0_ID": 396825, "CAL_MAG1_ID": 396809, "CAL_MAG0_PRIO": 50, "CAL_MAG1_PRIO": 75}
    send_px4(log, START_S + 1, px4_reals(first, 1) | px4_reals(second, 0), wholes | {"CAL_MAG1_ROT": 2})
    send_px4(log, START_S + 10.03, px4_reals(second, 1), {})
    contents = read(log, tmp_path)
    np.testing.assert_allclose(field_of(contents), RAW_NT, atol=0.1)
    assert contents.applied["1"].parameters["CAL_MAG1_ID"] == 396809
    assert any("PX4's calibration 1 undone" in note and "assumed of 2" in note for note in contents.notes)


def test_px4s_sensor_field_is_raw_and_turned(tmp_path: Path) -> None:
    log = Telemetry()
    send_compass(log, "SCALED_IMU", RAW_MG @ YAW_90)
    beat(log, PX4)
    reals = px4_reals(np.array([0.2, 0.1, 0.3]), 0)
    send_px4(log, START_S + 1, reals, {"CAL_MAG0_ID": 396825, "CAL_MAG0_PRIO": 75, "CAL_MAG0_ROT": 2})
    contents = read(log, tmp_path)
    np.testing.assert_allclose(field_of(contents), RAW_NT, atol=STEP_NT)
    assert not contents.applied["1"].undone


def test_px4_without_parameters_is_told(tmp_path: Path) -> None:
    log = Telemetry()
    send_compass(log, "SCALED_IMU", RAW_MG)
    beat(log, PX4)
    assert any("nothing can be undone" in note for note in read(log, tmp_path).notes)


def test_frames_decoded_in_parts_are_those_decoded_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = Telemetry()
    beat(log, ARDUPILOT)
    send_parameters(log, float(ONE.time_s[0]), own(OFFSET_MG))
    send_compass(log, "RAW_IMU", RAW_MG)
    whole = read(log, tmp_path).table
    monkeypatch.setattr("recordings.readers.tlog.frames.MOST_AT_ONCE", 7)
    parts = read(log, tmp_path).table
    assert parts.column_names == whole.column_names
    for name in whole.column_names:
        np.testing.assert_array_equal(parts[name].to_numpy(), whole[name].to_numpy(), err_msg=name)
