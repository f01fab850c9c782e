"""The streams of a vehicle's log as the columns of one magnetometer."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from recordings.columns import ATTITUDE
from recordings.readers.vehicle_log import VehicleLog, vector_columns
from recordings.streams import Interpolation, Stream
from scenarios.errors import InputError

LOG = Path("flight.log")
MAG_S = np.arange(0.0, 10.0, 0.1)
FIELD = vector_columns("mag", np.column_stack([np.cos(MAG_S), np.sin(MAG_S), MAG_S]))


def everything(name: str) -> bool:
    return True


def log_of(**streams: Stream) -> VehicleLog:
    return VehicleLog(
        {"1": Stream(MAG_S, FIELD), "2": Stream(MAG_S[::2], {k: v[::2] for k, v in FIELD.items()})}, streams
    )


def test_another_stream_comes_to_the_magnetometers_times() -> None:
    gyro_s = np.arange(-0.01, 10.0, 0.02)
    gyro = Stream(gyro_s, vector_columns("gyro", np.column_stack([gyro_s, 2 * gyro_s, -gyro_s])))
    table = log_of(imu=gyro).contents(LOG, everything, None).table
    np.testing.assert_allclose(table["gyro_y_rad_s"].to_numpy(), 2 * MAG_S)


def test_a_magnetometer_is_chosen_by_name_and_the_others_are_told() -> None:
    contents = log_of().contents(LOG, everything, "2")
    assert contents.magnetometer == "2"
    assert contents.table.num_rows == 50
    assert "--stream reads another: 1" in contents.notes[0]
    with pytest.raises(InputError, match="choose among 1, 2"):
        log_of().contents(LOG, everything, "3")


def test_samples_without_an_attitude_are_left_out_and_counted() -> None:
    at_s = np.arange(1.0, 10.0, 0.05)
    q = np.tile([1.0, 0.0, 0.0, 0.0], (len(at_s), 1))
    attitude = Stream(at_s, vector_columns("attitude", q), dict.fromkeys(ATTITUDE, Interpolation.SLERP))
    contents = log_of(att=attitude).contents(LOG, everything, None)
    assert contents.table["time_s"][0].as_py() == pytest.approx(1.0)
    assert "10 of 100 samples left out, without attitude" in contents.notes


def test_a_quantity_that_is_rarely_there_is_left_out() -> None:
    late = Stream(MAG_S[60:], {"temperature_degC": 20 + MAG_S[60:]})
    contents = log_of(baro=late).contents(LOG, everything, None)
    assert "temperature_degC" not in contents.table.column_names
    assert contents.table.num_rows == len(MAG_S)
    assert "left out, with a value at 40% of the samples alone: temperature_degC" in contents.notes


def test_a_late_fix_costs_the_position_and_no_sample() -> None:
    late_s = MAG_S[10:]
    fixes = Stream(late_s, vector_columns("position", np.column_stack([late_s, late_s, late_s])))
    contents = log_of(gps=fixes).contents(LOG, everything, None)
    assert contents.table.num_rows == len(MAG_S)
    assert "pos_east_m" not in contents.table.column_names


def test_what_several_motors_lack_is_one_note() -> None:
    late_s = MAG_S[5:]
    motors = {f"current_{k}_A": late_s + k for k in (1, 2, 3)}
    notes = log_of(esc=Stream(late_s, motors)).contents(LOG, everything, None).notes
    assert "5 of 100 samples left out, without current_1_A, current_2_A, current_3_A" in notes


def test_a_channel_that_never_changes_is_left_out() -> None:
    constant = Stream(MAG_S, {"mode": np.zeros(100), "throttle": MAG_S / 10})
    contents = log_of(rc=constant).contents(LOG, everything, None)
    assert "throttle" in contents.table.column_names
    assert "mode" not in contents.table.column_names


def test_times_since_1970_begin_at_zero() -> None:
    contents = VehicleLog({"": Stream(1.7e9 + MAG_S, FIELD)}).contents(LOG, everything, None)
    assert contents.table["time_s"][0].as_py() == 0.0
