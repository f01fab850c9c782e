"""PX4 logs as releases and vehicles differ: slots in any order, batteries, defaults, dropouts, encrypted files."""

from __future__ import annotations

import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from ulog_bytes import SYNC, TopicOf, UlogOf, message, parameter

from recordings.readers import load
from scenarios.errors import InputError
from tests.recordings.readers.px4_flight import Calibration, vehicle_magnetometer
from tests.recordings.readers.test_px4_calibration import (
    ARMED,
    CAL,
    DEVICE,
    FLIGHT,
    IN_AMPERES,
    LEVEL,
    NO_POWER,
    ROLL_180_YAW_90,
    YAW_180,
    assert_measured,
    field_of,
    power_topics,
    read,
    sensor_mag,
)

STRAIGHT = Rotation.identity()


def test_a_log_of_few_parameters_is_of_a_newer_release(tmp_path: Path) -> None:
    """Neither CAL_MAG0_EN nor _PRIO: sensor_mag is raw, and the off-diagonals were left at zero."""
    plain = replace(CAL, off_diagonal=(0.0, 0.0, 0.0))
    parameters = plain.parameters(0, DEVICE, 10)
    for name in ("XODIAG", "YODIAG", "ZODIAG", "PRIO"):
        del parameters[f"CAL_MAG0_{name}"]
    x = FLIGHT.sensor_G(ROLL_180_YAW_90)
    assert_measured(read(tmp_path, UlogOf([sensor_mag(x)], parameters)))
    body = vehicle_magnetometer(FLIGHT, plain.newest(x, NO_POWER, ROLL_180_YAW_90), DEVICE)
    assert_measured(read(tmp_path, UlogOf([body], parameters)))


def test_an_old_release_without_a_mark_in_its_parameters(tmp_path: Path) -> None:
    calibration = Calibration(CAL.offset, CAL.scale)
    parameters = calibration.parameters(0, DEVICE, 4, new=False) | {"CAL_MAG_PRIME": DEVICE}
    del parameters["CAL_MAG0_EN"]
    driven = sensor_mag(calibration.driver(FLIGHT.sensor_G(YAW_180)))
    assert_measured(read(tmp_path, UlogOf([driven], parameters, release=(1, 9, 2))))


def test_release_1_12_levels_no_external_sensor_and_takes_small_offsets(tmp_path: Path) -> None:
    """Its power compensation by current, too, acts while armed alone."""
    small = replace(IN_AMPERES, offset=(0.004, -0.003, 0.005), scale=(1.004, 0.997, 1.003), off_diagonal=(0.004, 0, 0))
    x, power = FLIGHT.sensor_G(ROLL_180_YAW_90), FLIGHT.current_A * 1e-3 * ARMED
    body = vehicle_magnetometer(FLIGHT, small.newest(x, power, ROLL_180_YAW_90), DEVICE)
    parameters = small.parameters(0, DEVICE, 10) | LEVEL | {"CAL_MAG_COMP_TYP": 2}
    log = UlogOf([body, *power_topics(controls=True)], parameters, release=(1, 12, 3))
    assert_measured(read(tmp_path, log))


def test_slots_in_any_order_and_a_sensor_that_is_disabled(tmp_path: Path) -> None:
    """Three sensors, instances 0 to 2, in slots 2, 0 and 1; PX4 uses the second; the third has priority 0."""
    devices, slots = (396809, 197388, 590114), (2, 0, 1)
    mountings = {0: (4, YAW_180), 1: (10, ROLL_180_YAW_90), 2: (0, STRAIGHT)}
    own = [replace(CAL, offset=(0.1 * k + 0.1, -0.2, 0.05 * k)) for k in range(3)]
    topics, parameters = [], {}
    for k, (device, slot) in enumerate(zip(devices, slots, strict=True)):
        number, mounting = mountings[k]
        x = (1 + 0.1 * k) * FLIGHT.sensor_G(mounting)
        topics.append(sensor_mag(x, 20, device, k))
        body = vehicle_magnetometer(FLIGHT, own[k].newest(x, NO_POWER, mounting), device)
        topics += [replace(body, instance=k, time_s=np.asarray(body.time_s) + 1e-4 * k)] if k < 2 else []
        parameters |= own[k].parameters(slot, device, number)
    parameters |= {"CAL_MAG1_PRIO": 0, "CAL_MAG3_ID": 0, "CAL_MAG3_PRIO": -1}
    log = UlogOf(topics, parameters)
    for k, slot in enumerate(slots):
        contents = read(tmp_path, log, str(slot))
        rows = slice(None, None, 20) if k == 2 else slice(None)
        np.testing.assert_allclose(field_of(contents), (1 + 0.1 * k) * FLIGHT.measured_nT[rows], atol=0.1)
        assert contents.applied[str(slot)].parameters[f"CAL_MAG{slot}_ID"] == devices[k]
    assert set(read(tmp_path, log).magnetometers) == {"2", "0", "1"}


def test_the_current_of_the_second_battery(tmp_path: Path) -> None:
    x = FLIGHT.sensor_G(STRAIGHT)
    body = vehicle_magnetometer(FLIGHT, IN_AMPERES.newest(x, FLIGHT.current_A * 1e-3, STRAIGHT), DEVICE)
    fields = {"voltage_v": ("float", 15 + 0 * FLIGHT.time_s), "current_a": ("float", FLIGHT.current_A)}
    idle = fields | {"current_a": ("float", 2 + 0 * FLIGHT.current_A)}
    batteries = [TopicOf("battery_status", FLIGHT.time_s, one, k) for k, one in enumerate((idle, fields))]
    parameters = IN_AMPERES.parameters(0, DEVICE, 0) | {"CAL_MAG_COMP_TYP": 3}
    assert_measured(read(tmp_path, UlogOf([body, *batteries], parameters)))


@pytest.mark.parametrize("kind", [0, 4])
def test_compensation_types_that_are_none(kind: int, tmp_path: Path) -> None:
    x = FLIGHT.sensor_G(STRAIGHT)
    body = vehicle_magnetometer(FLIGHT, CAL.newest(x, NO_POWER, STRAIGHT), DEVICE)
    parameters = CAL.parameters(0, DEVICE, 0) | {"CAL_MAG_COMP_TYP": kind}
    assert_measured(read(tmp_path, UlogOf([body, *power_topics(controls=False)], parameters)))


def default(name: str, value: float) -> bytes:
    """The message of a parameter's default, of the system and the vehicle."""
    key = f"float {name}".encode()
    return message("Q", bytes([3, len(key)]) + key + struct.pack("<f", value))


def test_defaults_dropouts_and_remarks_change_no_value(tmp_path: Path) -> None:
    """Messages Q, O, L, I and M among the samples; a default is no value in force."""
    x = FLIGHT.sensor_G(STRAIGHT)
    whole = UlogOf(
        [vehicle_magnetometer(FLIGHT, CAL.newest(x, NO_POWER, STRAIGHT), DEVICE)], CAL.parameters(0, DEVICE, 0)
    ).bytes()
    mark = message("S", SYNC)
    begin = whole.index(mark)
    middle = begin + len(mark) + (len(whole) - begin - len(mark)) // 400 * 200
    between = message("O", struct.pack("<H", 340)) + message("L", b"6" + bytes(8) + b"armed")
    defaults = default("CAL_MAG0_XOFF", 0.0) + default("CAL_MAG0_XSCALE", 1.0)
    early = whole.index(parameter("CAL_MAG0_XOFF", CAL.offset[0]))
    (tmp_path / "log.ulg").write_bytes(whole[:early] + defaults + whole[early:middle] + between + whole[middle:])
    contents = load(tmp_path / "log.ulg", lambda name: True)
    assert_measured(contents)
    assert not any("damaged" in note for note in contents.notes)


@pytest.mark.parametrize(
    ("name", "head"), [("a.ulgc", b"ULogKey\x01"), ("a.ulge", b"ULogEnc\x01"), ("b.ulgc", b"\x9c\x13\xf0 noise")]
)
def test_encrypted_logs_are_refused_in_one_line(name: str, head: bytes, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(head + bytes(400))
    with pytest.raises(InputError, match="is a log that PX4 encrypted") as caught:
        load(tmp_path / name, lambda column: True)
    assert "\n" not in str(caught.value)
