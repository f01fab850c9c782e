"""ArduPilot's logs: a simulated flight, calibrated as the autopilot does and laid out byte by byte, comes back."""

from __future__ import annotations

import datetime
from pathlib import Path

import numpy as np
import pytest
from dataflash_bytes import DOWN, Log, write_compass

from recordings.readers import load
from recordings.readers.ardupilot.messages import read_dataflash
from recordings.readers.ardupilot.vehicle import MODES, NO_MODE
from recordings.readers.base import FileContents
from scenarios.arrays import Array
from scenarios.errors import InputError
from tests.recordings.readers.damage import DAMAGED_FILES
from tests.recordings.readers.dataflash import FIELD_ENU, START_S, Flight, flight, ned_from_enu, product, rotated

IRON_NT = np.array([12_000.0, -7_000.0, 3_000.0])
SOFT = np.array([[1.08, 0.05, -0.03], [0.05, 0.93, 0.04], [-0.03, 0.04, 1.02]])
OFFSET_MG = np.array([-120.6, -71.3, 33.8])
DIAGONAL, MIXED, SCALE = np.array([1.07, 0.96, 1.03]), np.array([0.06, -0.05, 0.08]), 1.13
MOTOR_MG_A = np.array([3.1, -2.4, 5.7])
HALF_STEP_NT = 50.0


def everything(name: str) -> bool:
    return True


def refusal(path: Path) -> str:
    """The error of reading, "" for a log that is read; another exception than an InputError fails the test."""
    try:
        load(path, everything)
    except InputError as error:
        return str(error)
    return ""


def vectors(contents: FileContents, group: str, axes: str = "xyz", unit: str = "nT") -> Array:
    return np.column_stack([contents.table[f"{group}{axis}{'_' if unit else ''}{unit}"].to_numpy() for axis in axes])


def field_of(contents: FileContents) -> Array:
    return vectors(contents, "mag_")


def symmetric(diagonal: Array, mixed: Array) -> Array:
    """Rows x, y, z: diagonal and xy, xz, yz."""
    (a, b, c), (ab, ac, bc) = diagonal, mixed
    return np.array([[a, ab, ac], [ab, b, bc], [ac, bc, c]])


def as_logged(raw_nT: Array, offset_mG: Array, matrix: Array, motor_mG: Array | float = 0.0) -> Array:
    """What ArduPilot makes of the sensor's field: one sample at a time, in FRD and mG; returned in FLU and nT."""
    motor = np.broadcast_to(motor_mG, raw_nT.shape)
    offset = np.broadcast_to(offset_mG, raw_nT.shape)
    field = [matrix @ (raw * DOWN / 100 + o) + p for raw, o, p in zip(raw_nT, offset, motor, strict=True)]
    return np.array(field) * DOWN * 100


def measured(one: Flight) -> Array:
    """The sensor's field: iron of the vehicle, and its field from the current."""
    return one.field_nT @ SOFT.T + IRON_NT


def calibration(own: str = "", **changed: float) -> dict[str, float]:
    """The parameters of a compass; `own` stands after its names."""
    values = {f"COMPASS_SCALE{own}": SCALE}
    for kind, vector in (("OFS", OFFSET_MG), ("DIA", DIAGONAL), ("ODI", MIXED)):
        values |= {f"COMPASS_{kind}{own}_{axis}": float(x) for axis, x in zip("XYZ", vector, strict=True)}
    return values | changed


def write_state(log: Log, one: Flight) -> None:
    """Inertial unit at 50 Hz, attitude, satellites, battery, outputs, throttle, mode and arming."""
    dense = flight(5 * len(one.time_s), 0.02)
    gravity = rotated(dense.q * np.array([1.0, -1, -1, -1]), np.tile([0.0, 0.0, 9.81], (len(dense.q), 1)))
    log.layout("IMU", "QBfffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,T")
    log.rows("IMU", dense.time_s, 0, *(dense.rate_rad_s * DOWN).T, *(gravity * DOWN).T, 31.0 + dense.time_s / 100)
    log.layout("XKQ", "QBffff", "TimeUS,C,Q1,Q2,Q3,Q4")
    log.rows("XKQ", dense.time_s, 0, *ned_from_enu(dense.q).T)
    log.rows("XKQ", dense.time_s, 1, 1.0, 0.0, 0.0, 0.0)
    log.layout("BAT", "QBff", "TimeUS,Inst,Volt,Curr")
    log.rows("BAT", one.time_s, 0, 16 - one.current_A / 10, one.current_A)
    log.layout("GPS", "QBBIHBLLe", "TimeUS,I,Status,GMS,GWk,NSats,Lat,Lng,Alt")
    log.rows("GPS", one.time_s[::2], 0, 3, 219_552_200, 2382, 12, 52.4556363, 10.5585815, 47.77)
    log.rows("GPS", one.time_s[:1], 0, 1, 0, 0, 3, 0.0, 0.0, 0.0)
    log.layout("MODE", "QMBB", "TimeUS,Mode,ModeNum,Rsn")
    log.add("MODE", START_S + 0.5, 5, 5, 1)
    log.add("MODE", START_S + 20.0, 16, 16, 1)
    log.layout("MSG", "QZ", "TimeUS,Message")
    log.add("MSG", START_S, "ArduCopter V4.6.2 (1ebd4d99)")
    log.layout("ARM", "QBI", "TimeUS,ArmState,ArmChecks")
    log.add("ARM", START_S + 5.0, 1, 0)


def write_flight(path: Path, one: Flight, **changed: float) -> Path:
    """A flight with a calibrated compass 1, as a file."""
    return flight_log(one, **changed).write(path)


def flight_log(one: Flight, **changed: float) -> Log:
    """A flight with a calibrated compass 1, motors' term included."""
    log, motor_mG = Log(), one.current_A[:, None] * MOTOR_MG_A
    raw = measured(one) - 100 * motor_mG * DOWN  # the motors' own field, which the autopilot's term takes off
    logged = as_logged(raw, OFFSET_MG, SCALE * symmetric(DIAGONAL, MIXED), motor_mG)
    write_compass(log, one.time_s, logged, offset_mG=OFFSET_MG, motor_mG=motor_mG)
    log.parameters(START_S + 0.2, **calibration(), COMPASS_MOTCT=2, COMPASS_DEV_ID=97539, COMPASS_ORIENT=38)
    log.parameters(START_S + 0.2, **{f"COMPASS_MOT_{a}": float(x) for a, x in zip("XYZ", MOTOR_MG_A, strict=True)})
    log.parameters(START_S + 0.2, **changed)
    write_state(log, one)
    return log


@pytest.fixture(scope="module")
def contents(tmp_path_factory: pytest.TempPathFactory) -> FileContents:
    return load(write_flight(tmp_path_factory.mktemp("logs") / "flight.bin", flight()), everything)


def test_field_comes_back_to_the_formats_resolution(contents: FileContents) -> None:
    one = flight()
    expected = measured(one) - 100 * one.current_A[:, None] * MOTOR_MG_A * DOWN
    error = field_of(contents) - expected
    assert np.abs(error).max() < 4 * HALF_STEP_NT  # two numbers are cut, field and motors' term, and M is undone
    assert np.abs(error.mean(axis=0)).max() < 8.0  # the cut toward zero leaves no bias


def test_applied_calibration_is_what_the_autopilot_did(contents: FileContents) -> None:
    one = flight()
    applied = contents.applied["1"]
    raw = measured(one) - 100 * one.current_A[:, None] * MOTOR_MG_A * DOWN
    expected = as_logged(raw, OFFSET_MG, SCALE * symmetric(DIAGONAL, MIXED))
    np.testing.assert_allclose((raw - applied.offset_nT) @ applied.matrix.T, expected, atol=0.05)
    assert applied.parameters["COMPASS_ORIENT"] == 38
    assert applied.parameters["COMPASS_MOT_Z"] == pytest.approx(MOTOR_MG_A[2])
    assert (applied.autopilot, applied.compass) == ("ardupilot", 1)
    assert any("compass 1 undone (COMPASS_OFS_X -120.6" in note for note in contents.notes)


def test_attitude_rate_and_force_agree_with_the_field(tmp_path: Path) -> None:
    log, one = Log(), flight()
    write_compass(log, one.time_s, one.field_nT)
    write_state(log, one)
    contents = load(log.write(tmp_path / "flight.bin"), everything)
    time_s, field = contents.table["time_s"].to_numpy(), field_of(contents)
    q, rate = vectors(contents, "att_q", "wxyz", ""), vectors(contents, "gyro_", unit="rad_s")
    np.testing.assert_allclose(rotated(q, field), np.tile(FIELD_ENU, (len(q), 1)), atol=4 * HALF_STEP_NT)
    turned = -np.cross(rate, field)  # a fixed field seen from a turning body: dm/dt = -omega x m
    np.testing.assert_allclose(np.gradient(field, time_s, axis=0)[1:-1], turned[1:-1], atol=1500)
    assert np.abs(turned).max() > 15_000
    upright = rotated(q, vectors(contents, "accel_", unit="m_s2"))
    np.testing.assert_allclose(upright, np.tile([0.0, 0.0, 9.81], (len(q), 1)), atol=0.01)
    assert any("nothing can be undone" in note for note in contents.notes)
    assert not contents.applied


def test_place_date_phase_and_channels(contents: FileContents) -> None:
    assert contents.place == pytest.approx((52.4556363, 10.5585815, 47.77))
    assert contents.date == datetime.date(2025, 9, 2)
    noon = datetime.datetime(2025, 9, 2, 12, 58, 54, 200_000, tzinfo=datetime.UTC).timestamp()
    times_s = contents.table["time_s"].to_numpy()
    assert contents.start_s is not None
    assert contents.start_s + times_s[0] < noon < contents.start_s + times_s[-1]
    table = contents.table.to_pydict()
    assert [table["phase"][0], table["phase"][-1]] == ["loiter", "poshold"]
    assert table["phase"].index("poshold") == 200
    assert [sum(table["armed"][:50]), min(table["armed"][51:])] == [0, 1]
    np.testing.assert_allclose(table["current_1_A"], flight().current_A, rtol=1e-6)
    np.testing.assert_allclose(table["battery_voltage_V"], 16 - flight().current_A / 10, rtol=1e-6)
    np.testing.assert_allclose(table["temperature_degC"], 31 + flight().time_s / 100, rtol=1e-5)
    assert any(note.startswith("current_1_A is the battery's current") for note in contents.notes)
    assert any("heading comes from the compasses" in note for note in contents.notes)


@pytest.mark.parametrize(
    ("changed", "matrix"),
    [
        ({"COMPASS_SCALE": 1.6}, symmetric(DIAGONAL, MIXED)),
        ({"COMPASS_SCALE": 0.0}, symmetric(DIAGONAL, MIXED)),
        ({"COMPASS_SCALE": 1.5}, 1.5 * symmetric(DIAGONAL, MIXED)),
        ({"COMPASS_SCALE": 0.7}, 0.7 * symmetric(DIAGONAL, MIXED)),
        ({f"COMPASS_DIA_{axis}": 0.0 for axis in "XYZ"}, SCALE * np.eye(3)),
    ],
)
def test_autopilots_own_limits(changed: dict[str, float], matrix: Array, tmp_path: Path) -> None:
    log, one = Log(), flight(60)
    write_compass(log, one.time_s, as_logged(measured(one), OFFSET_MG, matrix), offset_mG=OFFSET_MG)
    log.parameters(START_S + 0.2, **calibration(**changed))
    contents = load(log.write(tmp_path / "flight.bin"), everything)
    np.testing.assert_allclose(field_of(contents), measured(one), atol=4 * HALF_STEP_NT)


def test_three_compasses_each_with_its_own_parameters(tmp_path: Path) -> None:
    """The autopilot's second place has the device whose parameters stand third, and the reverse."""
    log, one = Log(), flight(60)
    for place, factor in ((0, 1.0), (1, 0.8), (2, 1.2)):
        logged = as_logged(factor * measured(one), OFFSET_MG * (place + 1), symmetric(DIAGONAL, MIXED / (place + 1)))
        write_compass(log, one.time_s, logged, place, offset_mG=OFFSET_MG * (place + 1))
    for place, own in ((0, ""), (1, "3"), (2, "2")):
        scaled = dict(zip(("X", "Y", "Z"), (OFFSET_MG * (place + 1)).tolist(), strict=True))
        mixed = dict(zip(("X", "Y", "Z"), (MIXED / (place + 1)).tolist(), strict=True))
        changed = {f"COMPASS_OFS{own}_{axis}": value for axis, value in scaled.items()}
        changed |= {f"COMPASS_ODI{own}_{axis}": value for axis, value in mixed.items()} | {f"COMPASS_SCALE{own}": 0.0}
        log.parameters(START_S, **calibration(own, **changed))
        log.parameters(START_S, **{f"COMPASS_PRIO{place + 1}_ID": 1000 + place, f"COMPASS_DEV_ID{own}": 1000 + place})
    path = log.write(tmp_path / "flight.bin")
    for name, factor in (("1", 1.0), ("2", 0.8), ("3", 1.2)):
        contents = load(path, everything, name)
        np.testing.assert_allclose(field_of(contents), factor * measured(one), atol=4 * HALF_STEP_NT)
    assert contents.applied["3"].compass == 2
    assert "--stream reads another: 1, 2" in contents.notes[0]


def test_offsets_that_change_in_flight_are_undone_piece_by_piece(tmp_path: Path) -> None:
    """At 2 s by a parameter, at 4 s learned without one."""
    log, one, matrix = Log(), flight(60), SCALE * symmetric(DIAGONAL, MIXED)
    second, third = OFFSET_MG + np.array([40.3, -10.2, 5.5]), OFFSET_MG + np.array([90.0, 20.0, -35.0])
    elapsed_s = (one.time_s - START_S)[:, None]
    offset = np.where(elapsed_s < 1.95, OFFSET_MG, np.where(elapsed_s < 3.95, second, third))
    write_compass(log, one.time_s, as_logged(measured(one), offset, matrix), offset_mG=offset)
    log.parameters(START_S + 0.5, **calibration())
    log.parameters(START_S + 1.95, **{f"COMPASS_OFS_{a}": float(x) for a, x in zip("XYZ", second, strict=True)})
    contents = load(log.write(tmp_path / "flight.bin"), everything)
    np.testing.assert_allclose(field_of(contents), measured(one), atol=5 * HALF_STEP_NT)
    assert any("20 of 60 samples have other offsets than the parameters" in note for note in contents.notes)
    assert any("its calibration changed in the log" in note for note in contents.notes)


def test_times_are_the_samples_own_across_the_turn_of_their_counter(tmp_path: Path) -> None:
    log, one = Log(), flight(60)
    shift_s = 2**32 * 1e-6 - START_S - 3.0
    written_s = one.time_s + shift_s + 0.004 * np.random.default_rng(2).random(60)
    write_compass(log, written_s, one.field_nT, sampled_s=one.time_s + shift_s)
    contents = load(log.write(tmp_path / "flight.bin"), everything)
    np.testing.assert_allclose(contents.table["time_s"].to_numpy(), one.time_s + shift_s, atol=2e-6)


def test_old_log_with_numbered_messages_milliseconds_and_trim(tmp_path: Path) -> None:
    log, one = Log(), flight(60)
    for name, factor in (("MAG", 1.0), ("MAG2", 0.7)):
        log.layout(name, "IhhhhhhhhhB", "TimeMS,MagX,MagY,MagZ,OfsX,OfsY,OfsZ,MOfsX,MOfsY,MOfsZ,Health")
        log.rows(name, one.time_s, *np.trunc(factor * one.field_nT * DOWN / 100).T, *[0.0] * 6, 1)
    roll_back = np.array([np.cos(0.03), -np.sin(0.03), 0.0, 0.0])  # AHRS_TRIM_X of 0.06 rad
    pitch_back = np.array([np.cos(0.04), 0.0, np.sin(0.04), 0.0])  # AHRS_TRIM_Y of -0.08 rad
    w, x, y, z = product(ned_from_enu(one.q), product(roll_back, pitch_back)).T
    log.layout("ATT", "IccccCC", "TimeMS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw")
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x**2 + y**2))
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y**2 + z**2))
    angles = np.degrees([roll, np.arcsin(2 * (w * y - z * x)), np.mod(yaw, 2 * np.pi)])
    log.rows("ATT", one.time_s, 0.0, angles[0], 0.0, angles[1], 0.0, angles[2])
    log.layout("PARM", "Nf", "Name,Value")
    log.add("PARM", START_S, "AHRS_TRIM_X", 0.06)
    log.add("PARM", START_S, "AHRS_TRIM_Y", -0.08)
    log.layout("CURR", "Ihhhf", "TimeMS,Throttle,Volt,Curr,CurrTot")
    log.rows("CURR", one.time_s, 500, 1600 - 10 * one.current_A, 100 * one.current_A, 0.0)
    path = log.write(tmp_path / "flight.bin")
    contents = load(path, everything)
    turned = rotated(vectors(contents, "att_q", "wxyz", ""), field_of(contents))
    np.testing.assert_allclose(turned, np.tile(FIELD_ENU, (60, 1)), atol=4 * HALF_STEP_NT)
    np.testing.assert_allclose(contents.table["current_1_A"].to_numpy(), one.current_A, atol=0.011)
    second = load(path, everything, "2")
    np.testing.assert_allclose(field_of(second), 0.7 * one.field_nT, atol=2 * HALF_STEP_NT)


def test_motors_currents_and_outputs(tmp_path: Path) -> None:
    log, one = Log(), flight(60)
    write_compass(log, one.time_s, one.field_nT)
    log.layout("ESC", "QBff", "TimeUS,Instance,RPM,Curr")
    log.layout("RCOU", "QHHH", "TimeUS,C1,C2,C3")
    log.layout("CTUN", "Qff", "TimeUS,ThO,Alt")
    for motor in (0, 1):
        log.rows("ESC", one.time_s, motor, 4000 + one.current_A, (motor + 1) * one.current_A)
    output = 0.5 + 0.3 * np.sin(one.time_s)
    log.rows("RCOU", one.time_s, 1100 + 800 * output, 1500, 1100 + 800 * output**2)
    log.rows("CTUN", one.time_s, output, one.time_s)
    log.layout("VER", "QZ", "TimeUS,FWS")
    log.add("VER", START_S, "ArduCopter V4.6.2 (1ebd4d99)")
    log.parameters(
        START_S, MOT_PWM_MIN=1100, MOT_PWM_MAX=1900, SERVO1_FUNCTION=34, SERVO2_FUNCTION=7, SERVO3_FUNCTION=33
    )
    table = load(log.write(tmp_path / "flight.bin"), everything).table.to_pydict()
    np.testing.assert_allclose(table["current_2_A"], 2 * one.current_A, rtol=1e-6)
    np.testing.assert_allclose(table["motor_output_2"], output, atol=0.002)
    np.testing.assert_allclose(table["motor_output_1"], output**2, atol=0.002)
    np.testing.assert_allclose(table["throttle"], output, rtol=1e-6)
    assert {"ESC[0].RPM", "ESC[1].RPM", "CTUN.Alt"} <= table.keys()
    assert "RCOU.C1" not in table


def test_unhealthy_samples_are_left_out(tmp_path: Path) -> None:
    log, one = Log(), flight(60)
    write_compass(log, one.time_s, one.field_nT, health=np.where(np.arange(60) < 7, 0.0, 1.0))
    contents = load(log.write(tmp_path / "flight.bin"), everything)
    assert contents.table.num_rows == 53
    assert any(note.startswith("7 of 60 samples left out: the autopilot calls") for note in contents.notes)


def test_modes_are_those_of_the_library() -> None:
    mavutil = pytest.importorskip("pymavlink.mavutil")
    theirs = {
        "copter": mavutil.mode_mapping_acm,
        "plane": mavutil.mode_mapping_apm,
        "rover": mavutil.mode_mapping_rover,
        "sub": mavutil.mode_mapping_sub,
        "blimp": mavutil.mode_mapping_blimp,
    }
    for vehicle, names in theirs.items():
        ours = {number: name for number, name in MODES[vehicle].items() if name != NO_MODE}
        assert {number: ours[number] for number in names} == {number: name.lower() for number, name in names.items()}


def test_messages_are_those_of_the_library(tmp_path: Path) -> None:
    reader = pytest.importorskip("pymavlink.DFReader")
    path = write_flight(tmp_path / "flight.bin", flight(60))
    ours, theirs = read_dataflash(path), reader.DFReader_binary(str(path))
    numbers = {name: number for name, number in theirs.name_to_id.items() if name != "FMT"}
    counts = {name: theirs.counts[number] for name, number in numbers.items()}
    assert counts == {name: len(rows) for name, rows in ours.types.items() if name != "FMT"}
    last = theirs.recv_match(type=["GPS"])
    assert ours.types["GPS"].numbers("Lat")[0] == pytest.approx(last.Lat)


def test_damaged_bytes_cost_the_messages_they_hit(tmp_path: Path) -> None:
    path = write_flight(tmp_path / "flight.bin", flight(60))
    whole = bytearray(path.read_bytes())
    whole[len(whole) // 2 : len(whole) // 2 + 600] = bytes(range(256)) * 2 + bytes(88)
    path.write_bytes(whole)
    contents = load(path, everything)
    assert contents.table.num_rows > 45
    assert any("bytes are no message" in note for note in contents.notes)


@DAMAGED_FILES
def test_damaged_logs_are_read_or_refused(files: int, tmp_path: Path) -> None:
    path = write_flight(tmp_path / "flight.bin", flight(12))
    whole, rng = np.frombuffer(path.read_bytes(), np.uint8), np.random.default_rng(6)
    for trial in range(files):
        damaged = whole[: rng.integers(1, len(whole))] if trial % 3 == 0 else whole.copy()
        if trial % 3:
            hit = rng.random(len(damaged)) < 10.0 ** rng.uniform(-4, -1)
            damaged = np.where(hit, rng.integers(0, 256, len(damaged), np.uint8), damaged)
        path.write_bytes(damaged.tobytes())
        said = refusal(path)
        assert not said or (said.startswith(str(path)) and "\n" not in said)


def test_real_fragment(realdata: Path) -> None:
    contents = load(realdata / "native" / "ardupilot-fragment.bin", everything)
    applied = contents.applied["1"]
    field = (field_of(contents) - applied.offset_nT) @ applied.matrix.T
    np.testing.assert_allclose(field[0], [-4650, 23_650, -45_450], atol=1)  # MAG says -46, -236, 454 mG in FRD
    strength = np.linalg.norm(field, axis=1)
    assert np.all(np.abs(strength - 50_000) < 2500)
    assert contents.place == pytest.approx((52.4556, 10.5586, 47.8), abs=0.1)
    second = load(realdata / "native" / "ardupilot-fragment.bin", everything, "2")
    assert "COMPASS_ODI2_Z 0.07042" in "".join(second.notes)
