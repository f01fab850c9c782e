"""Telemetry logs: a simulated flight, laid out frame by frame, comes back with ArduPilot's calibration undone."""

from __future__ import annotations

import datetime
from pathlib import Path

import numpy as np
import pytest
from dataflash_bytes import DOWN

from recordings.readers import load
from recordings.readers.base import FileContents
from scenarios.errors import InputError
from tests.recordings.readers.damage import DAMAGED_FILES
from tests.recordings.readers.dataflash import FIELD_ENU, Flight, flight, ned_from_enu, rotated
from tests.recordings.readers.telemetry import MESSAGES, Telemetry, milligauss

IRON_NT = np.array([9000.0, -4000.0, 2500.0])
OFFSET_MG = np.array([-90.4, -40.2, 25.7])
MATRIX = np.array([[1.05, 0.04, -0.03], [0.04, 0.97, 0.06], [-0.03, 0.06, 1.02]])
SCALE = 1.11
MOTOR_MG_A = np.array([3.0, -2.5, 4.0])
STEP_NT = 100.0
PARAMETERS = {
    **{f"COMPASS_OFS_{axis}": x for axis, x in zip("XYZ", OFFSET_MG.tolist(), strict=True)},
    **{f"COMPASS_DIA_{axis}": x for axis, x in zip("XYZ", np.diag(MATRIX).tolist(), strict=True)},
    **{f"COMPASS_ODI_{axis}": float(MATRIX[pair]) for axis, pair in zip("XYZ", [(0, 1), (0, 2), (1, 2)], strict=True)},
    **{f"COMPASS_MOT_{axis}": x for axis, x in zip("XYZ", MOTOR_MG_A.tolist(), strict=True)},
    **{"COMPASS_SCALE": SCALE, "COMPASS_MOTCT": 2.0, "COMPASS_OFS2_X": 0.0},
    **{"SERVO1_FUNCTION": 0.0, "SERVO3_FUNCTION": 34.0, "MOT_PWM_MIN": 1100.0, "MOT_PWM_MAX": 1900.0},
}


def everything(name: str) -> bool:
    return True


def columns(contents: FileContents, *names: str) -> np.ndarray:
    return np.column_stack([contents.table[name].to_numpy() for name in names])


def field_of(contents: FileContents) -> np.ndarray:
    return columns(contents, *(f"mag_{axis}_nT" for axis in "xyz"))


def logged_mG(one: Flight) -> np.ndarray:
    """What ArduPilot sends: M s (raw + o) + k p, in FRD."""
    raw = (one.field_nT + IRON_NT) * DOWN / 100
    return (raw + OFFSET_MG) @ (SCALE * MATRIX).T + one.current_A[:, None] * MOTOR_MG_A


def write_flight(path: Path, one: Flight, version: int = 2, with_parameters: bool = True) -> Path:
    """A quadrotor's flight with two compasses: the second without calibration."""
    log, first, second = Telemetry(version), np.trunc(logged_mG(one)), milligauss(one.field_nT)
    gravity = rotated(one.q * [1.0, -1.0, -1.0, -1.0], np.tile([0.0, 0.0, 9.80665], (len(one.q), 1)))
    force, rate = gravity * DOWN / 9.80665e-3, one.rate_rad_s * DOWN * 1000
    q = ned_from_enu(one.q)
    for k, t in enumerate(one.time_s.tolist()):
        log.add("RAW_IMU", t, t * 1e6, *force[k], *rate[k], *first[k], 0, 3150)
        log.add("SCALED_IMU2", t, t * 1e3, *force[k], *rate[k], *second[k], 0)
        log.add("ATTITUDE_QUATERNION", t, t * 1e3, *q[k], 0, 0, 0)
        for shift in (-0.02, 0.02):
            log.add("SYS_STATUS", t + shift, *[0] * 4, 15_400, one.current_A[k] * 100, 0, 0, 0, 0, 0, 0, 80)
        pulses_us = 1100 + 8 * (k % 80)
        log.add("SERVO_OUTPUT_RAW", t, t * 1e6, 1500, 1500, pulses_us, *[1000] * 5, 0)
        log.add("VFR_HUD", t, 4.5, 3.2 + 0.01 * k, 100.0, 0.5, 90, 35 + k % 3)
        if k % 10 == 0:
            log.add("HEARTBEAT", t, 5 if k < 100 else 16, 2, 3, 128 if k >= 20 else 0, 4, 3)
            log.add("HEARTBEAT", t, 0, 6, 8, 0, 4, 3, sender=(255, 190))
            log.add("GPS_RAW_INT", t, t * 1e6, 473_977_420, 85_455_940, 488_130, 90, 120, 300, 0, 3, 14)
            log.add("SYSTEM_TIME", t, (1_714_564_800 + t) * 1e6, t * 1e3)
    for name, value in PARAMETERS.items() if with_parameters else ():
        log.add("PARAM_VALUE", one.time_s[3], value, len(PARAMETERS), 0, name.encode(), 9)
    return log.write(path)


@pytest.mark.parametrize("version", [1, 2])
def test_field_comes_back_to_the_formats_resolution(version: int, tmp_path: Path) -> None:
    one = flight(200)
    contents = load(write_flight(tmp_path / "flight.tlog", one, version), everything)
    error = field_of(contents) - one.field_nT - IRON_NT
    assert np.abs(error).max() < 1.6 * STEP_NT
    assert np.abs(error.mean(axis=0)).max() < 10.0
    applied = contents.applied["1"]
    expected = logged_mG(one) - one.current_A[:, None] * MOTOR_MG_A
    found = (one.field_nT + IRON_NT - applied.offset_nT) @ applied.matrix.T
    np.testing.assert_allclose(found * DOWN / 100, expected, atol=1e-3)
    assert any("compass 1 undone (COMPASS_OFS_X -90.4" in note for note in contents.notes)


def test_second_compass_attitude_rate_and_force_agree(tmp_path: Path) -> None:
    one = flight(200)
    contents = load(write_flight(tmp_path / "flight.tlog", one), everything, "2")
    np.testing.assert_allclose(field_of(contents), one.field_nT, atol=STEP_NT)
    q = columns(contents, *(f"att_q{part}" for part in "wxyz"))
    np.testing.assert_allclose(rotated(q, field_of(contents)), np.tile(FIELD_ENU, (200, 1)), atol=2 * STEP_NT)
    rate = columns(contents, *(f"gyro_{axis}_rad_s" for axis in "xyz"))
    np.testing.assert_allclose(rate, one.rate_rad_s, atol=0.0011)
    force = columns(contents, *(f"accel_{axis}_m_s2" for axis in "xyz"))
    np.testing.assert_allclose(rotated(q, force), np.tile([0.0, 0.0, 9.80665], (200, 1)), atol=0.03)


def test_place_date_phase_current_and_channels(tmp_path: Path) -> None:
    one = flight(200)
    contents = load(write_flight(tmp_path / "flight.tlog", one), everything)
    table = contents.table.to_pydict()
    assert contents.place == pytest.approx((47.397742, 8.545594, 488.13))
    assert contents.date == datetime.date(2024, 5, 1)
    np.testing.assert_allclose(table["current_1_A"], one.current_A, atol=0.02)
    assert [table["phase"][0], table["phase"][-1]] == ["loiter", "poshold"]
    assert [table["armed"][0], table["armed"][-1]] == [0.0, 1.0]
    np.testing.assert_allclose(table["time_s"], one.time_s, atol=1e-6)
    np.testing.assert_allclose(table["VFR_HUD.groundspeed"][1:-1], 3.2 + 0.01 * np.arange(1, 199), atol=0.011)
    np.testing.assert_allclose(table["throttle"][1:-1], 0.36, atol=0.011)
    np.testing.assert_allclose(table["motor_output_2"], np.arange(200) % 80 / 100, atol=1e-9)
    assert "SYS_STATUS.current_battery" not in table


def test_without_parameters_nothing_is_undone(tmp_path: Path) -> None:
    one = flight(60)
    contents = load(write_flight(tmp_path / "flight.tlog", one, with_parameters=False), everything)
    np.testing.assert_allclose(field_of(contents), logged_mG(one) * DOWN * 100, atol=STEP_NT)
    assert not contents.applied
    assert any("nothing can be undone" in note for note in contents.notes)


def test_currents_of_motors(tmp_path: Path) -> None:
    log, one = Telemetry(), flight(60)
    for k, t in enumerate(one.time_s.tolist()):
        log.add("HIGHRES_IMU", t, t * 1e6, *[0.0] * 6, *(one.field_nT[k] * DOWN / 1e5), 0, 0, 0, 20.0, 0, 0)
        log.add("ATTITUDE", t, round(t * 1e3), *[0.1 * np.sin(t)] * 3, 0, 0, 0)
        amperes = np.array([1.0, 2.0, 3.0, 0.0]) * one.current_A[k]
        for shift in (-0.02, 0.02):
            log.add("ESC_TELEMETRY_1_TO_4", t + shift, *[160] * 4, *np.round(100 * amperes), *[0] * 12, *[30] * 4)
    contents = load(log.write(tmp_path / "flight.tlog"), everything)
    np.testing.assert_allclose(field_of(contents), one.field_nT, atol=0.01)
    np.testing.assert_allclose(columns(contents, "current_3_A")[:, 0], 3 * one.current_A, rtol=0.02)
    assert "current_4_A" not in contents.table.column_names


def test_frames_are_those_of_the_library(tmp_path: Path) -> None:
    """pymavlink reads what the test writes: numbers, checksums and layouts are MAVLink's."""
    dialect = pytest.importorskip("pymavlink.dialects.v20.ardupilotmega")
    for name, (number, extra, form) in MESSAGES.items():
        theirs = dialect.mavlink_map[number]
        assert (theirs.msgname, theirs.crc_extra) == (name, extra)
        assert theirs.unpacker.format.startswith(form)
    path = write_flight(tmp_path / "flight.tlog", flight(20))
    parser = dialect.MAVLink(None)
    raw = path.read_bytes()
    start, count = 0, 0
    while start < len(raw):
        length = 12 + raw[start + 9]
        assert parser.decode(bytearray(raw[start + 8 : start + 8 + length])) is not None
        start, count = start + 8 + length, count + 1
    assert count > 100


def test_frames_with_a_wrong_checksum_are_left_out(tmp_path: Path) -> None:
    path = write_flight(tmp_path / "flight.tlog", flight(60))
    whole = bytearray(path.read_bytes())
    at = whole.index(b"\xfd", len(whole) // 2 + 1)
    whole[at + 14] ^= 0x55
    path.write_bytes(whole)
    contents = load(path, everything)
    assert contents.table.num_rows >= 58
    assert any("checksum is wrong" in note for note in contents.notes)


@DAMAGED_FILES
def test_damaged_logs_are_read_or_refused(files: int, tmp_path: Path) -> None:
    path = write_flight(tmp_path / "flight.tlog", flight(12))
    whole, rng = np.frombuffer(path.read_bytes(), np.uint8), np.random.default_rng(8)
    for trial in range(files):
        damaged = whole[: rng.integers(1, len(whole))] if trial % 3 == 0 else whole.copy()
        if trial % 3:
            hit = rng.random(len(damaged)) < 10.0 ** rng.uniform(-4, -1)
            damaged = np.where(hit, rng.integers(0, 256, len(damaged), np.uint8), damaged)
        path.write_bytes(damaged.tobytes())
        said = refusal(path)
        assert not said or (said.startswith(str(path)) and "\n" not in said)


def refusal(path: Path) -> str:
    """The error of reading, "" for a log that is read; another exception than an InputError fails the test."""
    try:
        load(path, everything)
    except InputError as error:
        return str(error)
    return ""
