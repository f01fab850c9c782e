"""Blackbox logs of a simulated flight: counts, frames, units, modes and places come back, and damage is survived."""

from __future__ import annotations

import datetime
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from orangebox import Parser
from scipy.spatial.transform import Rotation

from recordings.readers import FileContents, load
from recordings.readers.blackbox.frames import decoded_log
from scenarios.arrays import Array
from scenarios.errors import InputError
from tests.recordings.readers.blackbox_logs import BlackboxWriter, betaflight_fields, inav_fields, rows_of
from tests.recordings.readers.damage import DAMAGED_FILES
from tests.recordings.readers.flights import Flight, assert_same_flight
from tests.recordings.readers.test_contract import assert_read_or_refused

COUNTS_PER_NT = 3000 / 1e5  # QMC5883L
FRAME_S = np.arange(0.0, 12.0, 0.004)
READ_S = 0.02
"""Interval of the magnetometer's readings: five frames."""
START_US = 2**32 - 5_000_000
"""The clock of 32 bits wraps five seconds after the start."""
HEADERS = {
    "Firmware type": "Cleanflight",
    "Firmware revision": "Betaflight 4.5.1 (77d01ba3b) STM32F7X2",
    "Log start datetime": "2024-05-01T12:00:00.000+00:00",
    "gyro_scale": "0x3f800000",
    "acc_1G": "2048",
    "motorOutput": "158,2047",
    "vbatref": "1690",
    "blackbox_high_resolution": "1",
}
INAV_HEADERS = HEADERS | {
    "Firmware revision": "INAV 7.1.2 (4e1e59e) MATEKF405",
    "minthrottle": "1150",
    "maxthrottle": "1850",
    "motorOutput": "1150,1850",
    "blackbox_high_resolution": "0",
}
NWU = Rotation.from_euler("z", -90, degrees=True)
"""East, north, up to north, west, up."""


def held(time_s: Array) -> Array:
    """The time of the last reading of the magnetometer."""
    return READ_S * np.floor(time_s / READ_S + 1e-9)


def columns_of(time_s: Array, *, fine: float) -> dict[str, Array]:
    """The main fields that both firmwares have, as whole numbers in the log's units."""
    flight = Flight(time_s)
    return {
        "loopIteration": np.arange(len(time_s)),
        "time": (START_US + np.round(1e6 * time_s)) % 2**32,
        "axisI": np.column_stack([300 * np.sin(40 * time_s), 9 * np.cos(30 * time_s), 40_000 * np.sin(20 * time_s)]),
        "magADC": Flight(held(time_s)).field_nT * COUNTS_PER_NT,
        "gyroADC": fine * np.degrees(flight.rate_rad_s),
        "accSmooth": flight.specific_force_m_s2 / 9.80665 * 2048,
    }


def betaflight(time_s: Array = FRAME_S, headers: dict[str, str] = HEADERS) -> BlackboxWriter:
    turn = (NWU * Flight(time_s).rotation).as_quat(canonical=True)
    columns = columns_of(time_s, fine=10) | {
        "imuQuaternion": 32767 * turn[:, :3],
        "rcCommand": np.column_stack([np.zeros((len(time_s), 3)), 10_000 + 800 * time_s]),
        "vbatLatest": 1680 - 10 * time_s,
        "amperageLatest": 500 + 40 * time_s,
        "baroAlt": 30 * time_s,
        "motor": 158 + 1889 * (0.2 + 0.05 * np.outer(time_s, [1, 0.5, 0.1, 0])),
    }
    writer = BlackboxWriter(betaflight_fields(), headers)
    for k, row in enumerate(rows_of(columns)):
        if k % 1000 == 0:
            writer.slow(flightModeFlags=1 | 2 * (k >= 1000))
        writer.main(row)
        if k % 250 == 0 or k == len(time_s) - 1:
            writer.fix(474_000_000 + k, 85_000_000 - k, 5000 + k)
    return writer


@cache
def whole_log() -> bytes:
    """The log of the whole flight, made once."""
    return bytes(betaflight().end())


def inav() -> BlackboxWriter:
    yaw, pitch, roll = (NWU * Flight(FRAME_S).rotation).as_euler("ZYX").T
    columns = columns_of(FRAME_S, fine=1) | {
        "attitude": np.degrees(np.column_stack([roll, pitch, (-yaw) % (2 * np.pi)])) * 10,
        "vbat": 1680 - 10 * FRAME_S,
        "amperage": 500 + 40 * FRAME_S,
        "motor[0]": 1150 + 700 * (0.2 + 0.05 * FRAME_S),
        "navPos": 100 * np.column_stack([FRAME_S, -2 * FRAME_S, 3 * FRAME_S]),
    }
    columns["magADC"][1500] = 0  # a failed read
    writer = BlackboxWriter(inav_fields(), INAV_HEADERS)
    for k, row in enumerate(rows_of(columns)):
        if k % 500 == 0:
            writer.slow(activeFlightModeFlags=0 if k < 1000 else 1 | 1 << 4, IMUTemperature=300 + k // 100)
        writer.main(row)
    return writer


def read(data: bytes, place: Path, stream: str | None = None) -> tuple[dict[str, Array], FileContents]:
    path = place / "flight.bbl"
    path.write_bytes(data)
    contents = load(path, lambda name: True, stream)
    return {name: contents.table[name].to_numpy() for name in contents.table.column_names}, contents


def in_nT(table: dict[str, Array]) -> dict[str, Array]:
    return table | {f"mag_{a}_nT": table[f"mag_{a}_nT"] / COUNTS_PER_NT for a in "xyz"}


def test_betaflights_flight_comes_back(tmp_path: Path) -> None:
    table, contents = read(whole_log(), tmp_path)
    np.testing.assert_allclose(table["time_s"], START_US * 1e-6 + np.arange(0, 12, READ_S), atol=1e-6)
    field = Flight(np.arange(0, 12, READ_S)).field_nT
    for k, axis in enumerate("xyz"):
        np.testing.assert_allclose(table[f"mag_{axis}_nT"], field[:, k] * COUNTS_PER_NT, atol=0.51)
    assert_same_flight(in_nT(table), 80.0)
    assert contents.unit == "count"
    assert contents.frame == "flu"
    assert contents.date == datetime.date(2024, 5, 1)
    assert contents.place == pytest.approx((47.4, 8.5, 650.0), abs=2e-4)
    assert any("mag_calibration" in note and "nothing is undone" in note for note in contents.notes)


def test_betaflights_battery_motors_modes_and_channels(tmp_path: Path) -> None:
    table, _ = read(whole_log(), tmp_path)
    t = np.arange(0, 12, READ_S)
    np.testing.assert_allclose(table["battery_voltage_V"], 16.8 - 0.1 * t, atol=0.006)
    np.testing.assert_allclose(table["current_1_A"], 5 + 0.4 * t, atol=0.006)
    np.testing.assert_allclose(table["motor_output_1"], 0.2 + 0.05 * t, atol=0.001)
    np.testing.assert_allclose(table["throttle"], 0.08 * t, atol=0.001)
    np.testing.assert_allclose(table["baroAlt"], 30 * t, atol=0.51)
    np.testing.assert_allclose(table["axisI[2]"], 40_000 * np.sin(20 * t), atol=0.51)
    np.testing.assert_array_equal(table["phase"], np.where(t < 3.998, "ACRO", "ANGLE"))
    np.testing.assert_allclose(table["pos_up_m"], 0.1 * t / 0.004, atol=0.6)


def test_inavs_flight_comes_back_without_its_failed_read(tmp_path: Path) -> None:
    table, contents = read(inav().end(), tmp_path)
    t = table["time_s"] - START_US * 1e-6
    assert len(t) == 600
    assert np.count_nonzero(np.abs(t - held(t)) > 1e-3) == 1  # the reading at the failed one comes a frame later
    assert_same_flight(in_nT(table), 200.0)
    np.testing.assert_allclose(table["pos_north_m"], t, atol=0.01)
    np.testing.assert_allclose(table["pos_east_m"], -2 * t, atol=0.01)
    np.testing.assert_allclose(table["motor_output_1"], 0.2 + 0.05 * t, atol=0.001)
    assert set(table["phase"]) == {"ACRO", "ANGLE+RTH"}
    assert table["temperature_degC"][-1] == pytest.approx(32.5)
    assert any("maggain_x" in note for note in contents.notes)


def test_another_decoder_finds_the_same_numbers(tmp_path: Path) -> None:
    """At new readings from the second complete frame on; groups of varied length are unknown to that decoder."""
    data = betaflight(FRAME_S[:900], HEADERS | {"minthrottle": "1070"}).end()
    (tmp_path / "flight.bbl").write_bytes(data)
    parser = Parser.load(str(tmp_path / "flight.bbl"))
    theirs = {frame.data[0]: frame.data for frame in parser.frames()}
    ours = decoded_log(tmp_path, data).main.columns
    rows = [k for k, one in enumerate(ours["loopIteration"].tolist()) if one in theirs and one >= 32]
    assert len(rows) > 170
    for place, name in enumerate(parser.field_names[: len(ours)]):
        expected = [theirs[int(ours["loopIteration"][k])][place] for k in rows]
        np.testing.assert_array_equal(ours[name][rows], expected, err_msg=name)


def test_of_several_logs_the_longest_is_read_and_others_by_number(tmp_path: Path) -> None:
    data = betaflight(FRAME_S[:500]).end() + betaflight(FRAME_S[:1500]).end() + betaflight(FRAME_S[:700]).end()
    table, contents = read(data, tmp_path)
    assert len(table["time_s"]) == 300
    assert contents.notes[0].startswith("log 2 of 3 in the file is read, the longest")
    assert len(read(data, tmp_path, "3")[0]["time_s"]) == 140
    with pytest.raises(InputError, match="choose among 1 to 3"):
        read(data, tmp_path, "4")


def test_a_lost_stretch_costs_the_frames_up_to_the_next_complete_one(tmp_path: Path) -> None:
    data = whole_log()
    middle = len(data) // 2
    table, contents = read(data[:middle] + data[middle + 1234 :], tmp_path)
    assert 580 <= len(table["time_s"]) < 600
    assert_same_flight(in_nT(table), 1000.0)  # the first frame after the gap holds a reading up to 20 ms old
    assert any("damaged frames left out" in note for note in contents.notes)


def test_a_log_that_is_cut_off_is_read_to_its_end(tmp_path: Path) -> None:
    data = whole_log()
    table, contents = read(data[: len(data) // 2], tmp_path)
    assert len(table["time_s"]) >= 240
    assert any("no end mark" in note for note in contents.notes)


def test_a_log_that_ends_with_its_header_is_refused(tmp_path: Path) -> None:
    header = re.match(rb"(H .*\n)+", whole_log())
    assert header
    with pytest.raises(InputError):
        read(header[0], tmp_path)


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        (b"magADC", b"magABC", "the magnetometer was not logged"),
        (b"H Field P encoding:9,0", b"H Field P encoding:5,0", "unknown encoding or predictor 5"),
        (b"H Field P predictor:6", b"H Field P predictor:99", "unknown encoding or predictor 99"),
        (b"Data version:2", b"Data version:1", "data version 1"),
        (b"Field P", b"Field Q", "does not define its frames"),
    ],
)
def test_headers_that_cannot_be_used(old: bytes, new: bytes, what: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=what):
        read(betaflight(FRAME_S[:50]).end().replace(old, new), tmp_path)


@DAMAGED_FILES
def test_damaged_logs_are_read_in_part_or_refused(files: int, tmp_path: Path) -> None:
    whole, rng = np.frombuffer(betaflight(FRAME_S[:400]).end(), np.uint8), np.random.default_rng(3)
    path = tmp_path / "flight.bbl"
    for trial in range(files):
        damaged = whole.copy()
        at = rng.integers(0, len(whole), 1 + trial % 50)
        damaged[at] = rng.integers(0, 256, len(at))
        path.write_bytes(damaged[: rng.integers(1, len(whole)) if trial % 3 == 0 else None].tobytes())
        assert_read_or_refused(path)
