"""Measured logs: what is accepted and converted. What is refused: `test_bad_input.py`."""

from __future__ import annotations

import datetime
import os
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st

from recordings import read_recording
from recordings.columns import group_of
from recordings.units import UNITS, likely_unit, parse_maps
from recordings.writer import write_recording

N = 40
REALDATA = Path(os.environ.get("MAGBENCH_REALDATA", ""))
TARGET_OF = {
    "time": "time_s",
    "mag": "mag_x_nT",
    "gyro": "gyro_x_rad_s",
    "accel": "accel_x_m_s2",
    "position": "pos_up_m",
    "temperature": "temperature_degC",
    "current": "current_1_A",
}


def log(**more: Any) -> dict[str, Any]:
    angle = np.linspace(0, 6, N)
    return {
        "time_s": np.arange(N) * 0.1,
        "mag_x_nT": 30_000 * np.cos(angle),
        "mag_y_nT": 30_000 * np.sin(angle),
        "mag_z_nT": -40_000 + 100 * np.sin(3 * angle),
        **more,
    }


def write(path: Path, columns: dict[str, Any]) -> Path:
    if path.suffix == ".parquet":
        pq.write_table(pa.table(columns), path)
    else:
        rows = zip(*columns.values(), strict=True)
        cells = (["" if v is None else repr(float(v)) if isinstance(v, float) else str(v) for v in row] for row in rows)
        path.write_text("\n".join([",".join(columns), *(",".join(row) for row in cells)]) + "\n")
    return path


@pytest.mark.parametrize("suffix", ["parquet", "csv"])
def test_field_alone_is_enough(tmp_path: Path, suffix: str) -> None:
    columns = log()
    recording = read_recording(write(tmp_path / f"log.{suffix}", columns))
    np.testing.assert_array_equal(recording.time_s, columns["time_s"])
    np.testing.assert_array_equal(recording.mag_nT[:, 1], columns["mag_y_nT"])
    assert recording.gyro_rad_s is recording.att_q is recording.phase is recording.current_A is None


def test_mapped_and_converted(tmp_path: Path) -> None:
    columns = log()
    foreign = {
        "t": (columns["time_s"] * 1e3).round().astype(np.int64),
        "bx": columns["mag_x_nT"] / 1e3,
        "by": -columns["mag_y_nT"] / 1e3,
        "bz": columns["mag_z_nT"] / 1e5,
        "tempK": np.full(N, 293.15),
        "rpm": np.arange(N, dtype=np.int16),
    }
    maps = ["time_s=t,unit=ms", "mag_x_nT=bx,unit=uT", "mag_y_nT = by, unit=uT, scale=-1", "mag_z_nT=bz,unit=gauss"]
    recording = read_recording(write(tmp_path / "log.csv", foreign), maps=[*maps, "temperature_degC=tempK,unit=K"])
    np.testing.assert_allclose(recording.time_s, columns["time_s"], atol=1e-12)
    expected = np.column_stack([columns[f"mag_{a}_nT"] for a in "xyz"])
    np.testing.assert_allclose(recording.mag_nT, expected, rtol=1e-12)
    np.testing.assert_allclose(recording.temperature_degC, 20.0, atol=1e-12)
    assert recording.channels.keys() == {"rpm"}


def test_map_replaces_a_column_of_the_same_name(tmp_path: Path) -> None:
    columns = log(calibrated_x=np.linspace(10_000, 11_000, N))
    recording = read_recording(write(tmp_path / "log.parquet", columns), maps=["mag_x_nT=calibrated_x"])
    np.testing.assert_array_equal(recording.mag_nT[:, 0], columns["calibrated_x"])
    assert recording.channels == {}


def test_truth_never_enters(tmp_path: Path) -> None:
    columns = log(true_field_x_nT=np.ones(N), effect_hard_iron_x_nT=np.ones(N), effect2_scale_x_nT=np.ones(N))
    assert read_recording(write(tmp_path / "log.parquet", columns)).channels == {}


def test_run_of_a_dataset_read_as_a_log_gives_no_truth(tmp_path: Path, run: Any) -> None:
    for name in ("att_qw", "att_qx", "att_qy", "att_qz"):
        run.block[name][:] = 0.5
    run.write(tmp_path / "r.parquet")
    assert read_recording(tmp_path / "r.parquet", maps=["mag_x_nT=mag_x_nT,scale=-1"]).channels == {}


def test_channels_are_the_other_numbers(tmp_path: Path) -> None:
    columns = log(
        rod_A_m2=np.linspace(0, 1, N), armed=np.arange(N) > 3, note=["a"] * N, empty=[None] * N, gears=[1, 2] * (N // 2)
    )
    for suffix in ("parquet", "csv"):
        recording = read_recording(write(tmp_path / f"log.{suffix}", columns))
        assert recording.channels.keys() == {"rod_A_m2", "armed", "gears"}
        assert all(values.dtype == np.float64 for values in recording.channels.values())
        assert recording.channels["armed"].tolist() == [0.0] * 4 + [1.0] * (N - 4)


@pytest.mark.parametrize(
    ("told", "name", "factor"),
    [
        ("scalar_nT=x,unit=uT", "scalar_nT", 1e3),
        ("reference_y_nT=x,unit=G", "reference_y_nT", 1e5),
        ("altitude_m=x,unit=ft", "altitude_m", 0.3048),
        ("latitude_deg=x", "latitude_deg", 1.0),
    ],
)
def test_channels_with_a_meaning_may_be_mapped(tmp_path: Path, told: str, name: str, factor: float) -> None:
    recording = read_recording(write(tmp_path / "log.csv", log(x=np.linspace(1.0, 2.0, N))), maps=[told])
    np.testing.assert_allclose(recording.channels[name], factor * np.linspace(1.0, 2.0, N))
    assert "x" not in recording.channels


def test_depth_alone_is_a_channel_and_motors_are_sorted(tmp_path: Path) -> None:
    currents = {f"current_{i}_A": np.full(N, float(i)) for i in (10, 2, 1)}
    recording = read_recording(write(tmp_path / "log.parquet", log(pos_up_m=-np.arange(N) * 1.0, **currents)))
    assert recording.pos_enu_m is None
    assert recording.channels.keys() == {"pos_up_m"}
    assert recording.current_A[0].tolist() == [1.0, 2.0, 10.0]
    assert recording.motors == (1, 2, 10)


def test_a_motor_that_was_not_measured_leaves_the_others_their_numbers(tmp_path: Path) -> None:
    currents = {"current_1_A": np.full(N, 1.0), "current_2_A": [None] * N, "current_10_A": np.full(N, 10.0)}
    recording = read_recording(write(tmp_path / "log.parquet", log(**currents)))
    assert recording.motors == (1, 10)
    write_recording(recording, tmp_path / "again.csv")
    again = read_recording(tmp_path / "again.csv")
    assert again.motors == (1, 10)
    np.testing.assert_array_equal(again.current_A[0], [1.0, 10.0])


def test_array_of_sensors(tmp_path: Path) -> None:
    columns = log()
    array = {"time_s": columns["time_s"]}
    for k in (1, 2):
        array |= {f"mag{k}_{a}_nT": columns[f"mag_{a}_nT"] * k for a in "xyz"}
    recording = read_recording(write(tmp_path / "log.csv", array))
    np.testing.assert_array_equal(recording.array_mag_nT[1], 2 * recording.mag_nT)


def test_timestamps_become_seconds(tmp_path: Path) -> None:
    start = datetime.datetime(2024, 5, 27, 12, 0, 0)
    stamps = [start + datetime.timedelta(milliseconds=100 * i) for i in range(N)]
    for suffix in ("parquet", "csv"):
        recording = read_recording(write(tmp_path / f"log.{suffix}", log(time_s=stamps)))
        np.testing.assert_allclose(recording.time_s, np.arange(N) * 0.1, atol=1e-9)


def test_blanks_around_column_names_do_not_matter(tmp_path: Path) -> None:
    table = pa.table(log())
    pq.write_table(table.rename_columns([f" {name} " for name in table.column_names]), tmp_path / "log.parquet")
    recording = read_recording(tmp_path / "log.parquet")
    np.testing.assert_array_equal(recording.mag_nT[:, 0], log()["mag_x_nT"])


@pytest.mark.parametrize("separator", [";", "\t", ", "])
def test_separators_byte_order_mark_and_line_ends(tmp_path: Path, separator: str) -> None:
    path = write(tmp_path / "log.csv", log(phase=["spiral"] * N))
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b",", separator.encode()).replace(b"\n", b"\r\n"))
    recording = read_recording(path)
    np.testing.assert_array_equal(recording.mag_nT[:, 0], log()["mag_x_nT"])
    assert recording.phase[0].strip() == "spiral"


def test_number_that_looks_whole_for_a_long_time(tmp_path: Path) -> None:
    """Fractions that begin after the first megabyte: the type of a column is that of all its cells."""
    n = 60_000
    spin = np.arange(n) * 0.1
    columns = {"time_s": np.arange(n), "mag_x_nT": 3e4 * np.cos(spin), "mag_y_nT": 3e4 * np.sin(spin)}
    columns |= {"mag_z_nT": spin + 1e4, "throttle": [0] * (n - 1) + [0.5]}
    recording = read_recording(write(tmp_path / "log.csv", columns))
    assert recording.channels["throttle"][-1] == 0.5


@pytest.mark.parametrize("suffix", ["parquet", "csv"])
def test_slower_column_is_interpolated(tmp_path: Path, suffix: str) -> None:
    truth = np.linspace(10, 20, N)
    slow = [float(v) if i % 4 == 1 else None for i, v in enumerate(truth)]
    recording = read_recording(write(tmp_path / f"log.{suffix}", log(temperature_degC=slow)))
    np.testing.assert_allclose(recording.temperature_degC[1:38], truth[1:38], rtol=1e-12)
    assert recording.temperature_degC[0] == truth[1]
    assert recording.temperature_degC[39] == truth[37]


def test_slower_attitude_goes_the_shorter_way_round_whatever_its_sign(tmp_path: Path) -> None:
    half = np.linspace(0, 1.5, N)
    q = np.column_stack([np.cos(half), 0 * half, 0 * half, np.sin(half)])
    flipped = q * np.where(np.arange(N) // 4 % 2, -1.0, 1.0)[:, None]
    flipped[np.arange(N) % 4 != 0] = np.nan
    columns = log(**{f"att_q{a}": flipped[:, i] for i, a in enumerate("wxyz")})
    recording = read_recording(write(tmp_path / "log.parquet", columns))
    cosine = np.abs(np.sum(recording.att_q * q, axis=1))[:37]
    assert 2 * np.degrees(np.arccos(np.minimum(cosine, 1))).max() < 0.1
    np.testing.assert_allclose(np.linalg.norm(recording.att_q, axis=1), 1, atol=1e-12)


def test_quaternion_with_few_digits_is_normalised(tmp_path: Path) -> None:
    columns = log(att_qw=[0.7071] * N, att_qx=[0.7071] * N, att_qy=[0.0] * N, att_qz=[0.0] * N)
    recording = read_recording(write(tmp_path / "log.csv", columns))
    np.testing.assert_allclose(recording.att_q[0], [0.5**0.5, 0.5**0.5, 0, 0], atol=1e-12)


def test_gaps_of_a_channel_are_bridged(tmp_path: Path) -> None:
    event = np.full(N, np.nan)
    event[[2, 30]] = 1.0, 2.0
    event[5] = np.inf
    recording = read_recording(write(tmp_path / "log.parquet", log(rod=event, never=np.full(N, np.nan))))
    assert recording.channels.keys() == {"rod"}
    assert recording.channels["rod"][[0, 16, 39]].tolist() == [1.0, 1.5, 2.0]


@given(
    st.sampled_from([(kind, unit) for kind, units in UNITS.items() for unit in units]),
    st.floats(-1e6, 1e6),
    st.floats(0.1, 10),
)
def test_units_are_affine_and_invertible(unit: tuple[str, str], value: float, scale: float) -> None:
    kind, name = unit
    (one,) = parse_maps([f"{TARGET_OF[kind]}=a,unit={name},scale={scale!r}"])
    factor, offset = UNITS[kind][name]
    converted = one.convert(np.array([value, 0.0, 1.0]))
    np.testing.assert_allclose((converted[0] / scale - offset) / factor, value, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(converted[2] - converted[1], scale * factor, rtol=1e-6)


@given(st.sampled_from(sorted(UNITS["mag"])), st.floats(20_000, 70_000))
def test_earth_field_in_any_unit_is_recognised(unit: str, field_nT: float) -> None:
    factor = UNITS["mag"][unit][0]
    guess = likely_unit(field_nT / factor)
    assert guess is not None
    assert UNITS["mag"][guess][0] == factor


@pytest.mark.parametrize(
    ("kind", "unit", "value", "expected"),
    [
        ("mag", "T", 5e-5, 50_000.0),
        ("mag", "mG", 500.0, 50_000.0),
        ("mag", "G", 0.5, 50_000.0),
        ("gyro", "deg/s", 180.0, np.pi),
        ("accel", "g", 1.0, 9.80665),
        ("temperature", "degF", 212.0, 100.0),
        ("temperature", "K", 273.15, 0.0),
        ("time", "us", 2_000_000.0, 2.0),
        ("current", "mA", 1500.0, 1.5),
        ("position", "ft", 10.0, 3.048),
    ],
)
def test_known_conversions(kind: str, unit: str, value: float, expected: float) -> None:
    (one,) = parse_maps([f"{TARGET_OF[kind]}=a,unit={unit}"])
    assert one.convert(np.array([value]))[0] == pytest.approx(expected, rel=1e-12, abs=1e-9)


def test_every_unit_belongs_to_a_group_of_columns() -> None:
    assert {group_of(name) for name in TARGET_OF.values()} == set(UNITS) == set(TARGET_OF)


@pytest.mark.skipif(not REALDATA.name, reason="MAGBENCH_REALDATA does not name the folder of measured recordings")
def test_measured_recordings_are_accepted_unchanged() -> None:
    files = sorted(REALDATA.glob("*/*.parquet"))
    assert files
    for path in files:
        recording, table = read_recording(path), pq.read_table(path)
        used = 4 + sum(
            0 if values is None else 1 if values.ndim == 1 else values.shape[1]
            for values in (
                recording.gyro_rad_s,
                recording.accel_m_s2,
                recording.att_q,
                recording.pos_enu_m,
                recording.temperature_degC,
                recording.current_A,
            )
        )
        assert used + len(recording.channels) == table.num_columns
        for i, axis in enumerate("xyz"):
            np.testing.assert_array_equal(recording.mag_nT[:, i], table[f"mag_{axis}_nT"].to_numpy())
        if recording.att_q is not None:
            np.testing.assert_array_equal(recording.att_q[:, 0], table["att_qw"].to_numpy())
