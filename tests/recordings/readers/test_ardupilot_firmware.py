"""ArduPilot's compasses as releases of ten years log them: each flight's field comes back through its own formulas."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dataflash_bytes import DOWN, Log, write_compass

from recordings.readers import load
from recordings.readers.base import FileContents
from scenarios.arrays import Array
from tests.recordings.readers.dataflash import FIELD_ENU, START_S, Flight, flight, ned_from_enu, rotated

IRON_NT = np.array([-8_000.0, 11_000.0, 4_500.0])
OFFSET_MG = np.array([73.2, 141.7, -58.4])
MATRIX = np.array([[1.09, -0.06, 0.05], [-0.06, 0.94, 0.07], [0.05, 0.07, 1.04]])
MOTOR_MG = np.array([42.0, -33.0, 61.0])
"""At full throttle."""
MOTOR_MG_A = np.array([3.3, -1.9, 4.6])
STEP_NT = 100.0
FIELDS = "MagX,MagY,MagZ,OfsX,OfsY,OfsZ"
ONE = flight(120)


def throttle(one: Flight) -> Array:
    return 0.45 + 0.3 * np.sin(1.3 * one.time_s)


def parameters(own: str = "", *, offset_mG: Array = OFFSET_MG, **more: float) -> dict[str, float]:
    """The calibration of a compass, `own` after the names."""
    pairs = {"X": MATRIX[0, 1], "Y": MATRIX[0, 2], "Z": MATRIX[1, 2]}
    found = {f"COMPASS_OFS{own}_{axis}": float(x) for axis, x in zip("XYZ", offset_mG, strict=True)}
    found |= {f"COMPASS_DIA{own}_{axis}": float(x) for axis, x in zip("XYZ", np.diag(MATRIX), strict=True)}
    return found | {f"COMPASS_ODI{own}_{axis}": float(x) for axis, x in pairs.items()} | more


def vector(name: str, values: Array) -> dict[str, float]:
    return {f"{name}_{axis}": float(x) for axis, x in zip("XYZ", values, strict=True)}


def raw_mG(one: Flight = ONE) -> Array:
    """The sensor's field with iron, in FRD."""
    return (one.field_nT + IRON_NT) * DOWN / 100


def logged(offset_mG: Array | None = None, motor_mG: Array | float = 0.0, *, motors_first: bool = False) -> Array:
    """What the firmware writes of the field, FRD, mG: sample by sample."""
    offsets = np.broadcast_to(OFFSET_MG if offset_mG is None else offset_mG, (len(ONE.time_s), 3))
    motors = np.broadcast_to(motor_mG, (len(ONE.time_s), 3))
    found = []
    for x, o, p in zip(raw_mG(), offsets, motors, strict=True):
        found.append(MATRIX @ (x + o + p) if motors_first else MATRIX @ (x + o) + p)
    return np.array(found)


def read(log: Log, tmp_path: Path, stream: str | None = None) -> FileContents:
    return load(log.write(tmp_path / "flight.bin"), lambda name: True, stream)


def assert_raw(contents: FileContents, expected_nT: Array | None = None, within: float = 1.7) -> None:
    """The sensor's field within steps of the format."""
    found = np.column_stack([contents.table[f"mag_{axis}_nT"].to_numpy() for axis in "xyz"])
    expected = ONE.field_nT + IRON_NT if expected_nT is None else expected_nT
    np.testing.assert_allclose(found, expected, atol=within * STEP_NT)


def of_firmware(text: str) -> Log:
    log = Log()
    log.layout("MSG", "QZ", "TimeUS,Message")
    log.add("MSG", START_S, text)
    return log


def write_throttle(log: Log) -> None:
    log.layout("CTUN", "Qff", "TimeUS,ThO,Alt")
    log.rows("CTUN", ONE.time_s, throttle(ONE), 0.1 * ONE.time_s)


@pytest.mark.parametrize(
    ("text", "more", "first"),
    [
        ("ArduCopter V3.5.4 (284349c3)", {}, True),
        ("APM:Copter V3.3.3 (acf1e10c)", {}, True),
        ("ArduCopter V3.6.12 (c1b1ad4d)", {}, False),
        ("ArduPlane V3.8.5 (abcdef12)", {}, True),
        ("ArduPlane V4.1.7", {}, False),
        ("ArduCopter V3.5.9-dev", {"COMPASS_PMOT_EN": 0.0}, False),
        ("Pixhawk 00320031", {}, False),
    ],
)
def test_the_motors_term_comes_before_the_soft_iron_in_old_releases(
    text: str, more: dict[str, float], first: bool, tmp_path: Path
) -> None:
    log, motor_mG = of_firmware(text), np.outer(throttle(ONE), MOTOR_MG)
    field = logged(None, motor_mG, motors_first=first) * DOWN * 100
    write_compass(log, ONE.time_s, field, offset_mG=OFFSET_MG, motor_mG=motor_mG)
    log.parameters(START_S, **parameters(**more))
    assert_raw(read(log, tmp_path), within=2.5)


def test_the_motors_term_of_a_log_that_does_not_give_it(tmp_path: Path) -> None:
    """Whole numbers of 2013: MAG without the term, throttle by CTUN, gains that change at 5 s."""
    log, later = of_firmware("ArduCopter V4.0.7"), ONE.time_s > START_S + 5.03
    gain = np.where(later[:, None], 0.5 * MOTOR_MG, MOTOR_MG)
    field = np.trunc(logged(None, throttle(ONE)[:, None] * gain))
    log.layout("MAG", "Qhhhhhh", f"TimeUS,{FIELDS}")
    log.rows("MAG", ONE.time_s, *field.T, *np.trunc(OFFSET_MG))
    write_throttle(log)
    log.parameters(START_S, **parameters(COMPASS_MOTCT=1), **vector("COMPASS_MOT", MOTOR_MG))
    log.parameters(START_S + 5.03, **vector("COMPASS_MOT", 0.5 * MOTOR_MG))
    contents = read(log, tmp_path)
    assert_raw(contents)
    assert any("the motors' term by its parameters" in note for note in contents.notes)


def test_a_term_whose_current_is_not_logged_is_told(tmp_path: Path) -> None:
    log = of_firmware("ArduCopter V4.0.7")
    log.layout("MAG", "Qhhhhhh", f"TimeUS,{FIELDS}")
    log.rows("MAG", ONE.time_s, *np.trunc(logged()).T, *np.trunc(OFFSET_MG))
    log.parameters(START_S, **parameters(COMPASS_MOTCT=2), **vector("COMPASS_MOT", MOTOR_MG))
    assert any("the log lacks the battery's current" in note for note in read(log, tmp_path).notes)


def test_the_term_of_each_motor(tmp_path: Path) -> None:
    """Outputs 2 and 4 drive motors 1 and 3; c (V u)^0.7 of each."""
    log, volt = of_firmware("ArduCopter V4.5.0"), 15.0 + np.cos(0.4 * ONE.time_s)
    output = {1: throttle(ONE), 3: 0.5 * throttle(ONE) ** 2}
    gains = {1: np.array([5.0, -7.0, 9.0]), 3: np.array([-4.0, 6.0, 3.0])}
    motor_mG = sum(np.outer((volt * output[k]) ** 0.7, gains[k]) for k in (1, 3))
    log.layout("MAG", "QBfff", "TimeUS,I,MagX,MagY,MagZ")
    log.rows("MAG", ONE.time_s, 0, *logged(None, motor_mG).T)
    log.layout("BAT", "QBff", "TimeUS,Inst,Volt,Curr")
    log.rows("BAT", ONE.time_s, 0, volt, 9 + np.sin(ONE.time_s))
    log.layout("RCOU", "QHHHH", "TimeUS,C1,C2,C3,C4")
    log.rows("RCOU", ONE.time_s, 1500, np.round(1000 + 1000 * output[1]), 1500, np.round(1000 + 1000 * output[3]))
    log.parameters(START_S, **parameters(COMPASS_PMOT_EN=1, COMPASS_PMOT_EXP=0.7, COMPASS_MOTCT=2))
    log.parameters(START_S, **vector("COMPASS_PMOT1", gains[1]), **vector("COMPASS_PMOT3", gains[3]))
    log.parameters(START_S, SERVO2_FUNCTION=33, SERVO4_FUNCTION=35, SERVO1_FUNCTION=0, MOT_PWM_MIN=1000)
    assert_raw(read(log, tmp_path), within=0.1)


def test_use_counts_places_and_calibrations_count_devices(tmp_path: Path) -> None:
    """COMPASS_USE 0 puts the first place last; the device of the second place has the third parameters."""
    log = of_firmware("ArduPlane V4.3.1")
    for place, factor in ((0, 1.0), (1, 0.9)):
        write_compass(log, ONE.time_s, factor * logged(OFFSET_MG) * DOWN * 100, place, offset_mG=OFFSET_MG)
    log.parameters(START_S, **parameters(), **parameters("3"), COMPASS_USE=0, COMPASS_USE2=1, COMPASS_USE3=0)
    log.parameters(START_S, COMPASS_PRIO1_ID=11, COMPASS_PRIO2_ID=33, COMPASS_DEV_ID=11, COMPASS_DEV_ID3=33)
    contents = read(log, tmp_path)
    assert contents.magnetometer == "2"
    assert contents.applied["2"].compass == 3
    inverse = np.linalg.inv(MATRIX)
    assert_raw(contents, (0.9 * logged(OFFSET_MG) @ inverse.T - OFFSET_MG) * DOWN * 100)


def test_offsets_that_the_log_leaves_at_zero_are_the_parameters(tmp_path: Path) -> None:
    log = of_firmware("ArduRover V4.2.3")
    write_compass(log, ONE.time_s, logged() * DOWN * 100)
    log.parameters(START_S, **parameters())
    assert_raw(read(log, tmp_path))


def test_a_calibration_in_flight_starts_from_zero_offsets(tmp_path: Path) -> None:
    log, first = of_firmware("ArduCopter V4.5.0"), ONE.time_s < START_S + 6.0
    offset = np.where(first[:, None], 0.0, OFFSET_MG)
    write_compass(log, ONE.time_s, logged(offset) * DOWN * 100, offset_mG=offset)
    log.parameters(START_S, **parameters(offset_mG=np.zeros(3)))
    log.parameters(START_S + 5.96, **vector("COMPASS_OFS", OFFSET_MG))
    assert_raw(read(log, tmp_path), within=2.2)


def test_bursts_without_a_number_are_left_out(tmp_path: Path) -> None:
    log, field = of_firmware("ArduSub V4.1.0"), logged()
    field[30:37] = np.nan
    field[60, 1] = np.inf
    log.layout("MAG", "QBfff", "TimeUS,I,MagX,MagY,MagZ")
    log.rows("MAG", ONE.time_s, 0, *field.T)
    log.parameters(START_S, **parameters())
    kept = np.isfinite(field).all(axis=1)
    contents = read(log, tmp_path)
    assert_raw(contents, (ONE.field_nT + IRON_NT)[kept], within=0.01)
    assert any(note.startswith("8 of 120 samples left out: they hold no number") for note in contents.notes)


@pytest.mark.parametrize(("form", "unit"), [("Qccc", 1.0), ("Qhhh", 100.0), ("Qfff", 1.0)])
def test_angles_in_degrees_and_hundredths(form: str, unit: float, tmp_path: Path) -> None:
    log, (w, x, y, z) = of_firmware("ArduCopter V3.2.1"), ned_from_enu(ONE.q).T
    write_compass(log, ONE.time_s, ONE.field_nT)
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x**2 + y**2))
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y**2 + z**2))
    angles = np.degrees([roll, np.arcsin(2 * (w * y - z * x)), yaw]) * unit
    log.layout("ATT", form, "TimeUS,Roll,Pitch,Yaw")
    log.rows("ATT", ONE.time_s, *angles)
    table = read(log, tmp_path).table
    q, m = (np.column_stack([table[name].to_numpy() for name in names]) for names in (Q, M))
    np.testing.assert_allclose(rotated(q, m), np.tile(FIELD_ENU, (len(q), 1)), atol=2 * STEP_NT)


Q = tuple(f"att_q{part}" for part in "wxyz")
M = tuple(f"mag_{axis}_nT" for axis in "xyz")


def test_two_receivers_a_late_fix_and_a_cold_inertial_unit(tmp_path: Path) -> None:
    """The second receiver alone gets a fix, after 4 s; the temperature is the barometer's."""
    log, later = of_firmware("ArduSub V4.1.0"), ONE.time_s > START_S + 4
    write_compass(log, ONE.time_s, ONE.field_nT)
    log.layout("GPS", "QBBIHLLe", "TimeUS,I,Status,GMS,GWk,Lat,Lng,Alt")
    fix: dict[str, Any] = {"GMS": 100_000 + 1000 * ONE.time_s, "GWk": 2300}
    log.rows("GPS", ONE.time_s, 0, 1, 0, 0, 0.0, 0.0, 0.0)
    log.rows("GPS", ONE.time_s, 1, np.where(later, 3, 1), *fix.values(), np.where(later, -33.5, 0.0), 151.2, 12.0)
    log.layout("IMU", "QBfffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,T")
    log.rows("IMU", ONE.time_s, 0, *(ONE.rate_rad_s * DOWN).T, 0.0, 0.0, -9.8, 0.0)
    log.layout("BARO", "QBfc", "TimeUS,I,Press,Temp")
    log.rows("BARO", ONE.time_s, 0, 101_325 + ONE.time_s, 20 + 0.1 * ONE.time_s)
    contents = read(log, tmp_path)
    assert contents.place == pytest.approx((-33.5, 151.2, 12.0))
    np.testing.assert_allclose(contents.table["temperature_degC"].to_numpy(), 20 + 0.1 * ONE.time_s, atol=0.011)
    assert contents.table.num_rows == 120


def test_a_log_whose_beginning_was_lost(tmp_path: Path) -> None:
    log = of_firmware("ArduCopter V4.5.0")
    write_compass(log, ONE.time_s, ONE.field_nT)
    (tmp_path / "flight.bin").write_bytes(bytes(range(200)) + log.data())
    contents = load(tmp_path / "flight.bin", lambda name: True)
    assert_raw(contents, ONE.field_nT)
