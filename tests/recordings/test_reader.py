"""What was written is read back as Recording and Truth, and the truth never reaches a recording."""

from __future__ import annotations

import datetime
import decimal
import math
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from recordings import (
    Recording,
    finish_dataset,
    open_dataset_for_writing,
    read_recording,
    read_run,
    run_path,
    write_recording,
)
from recordings.metadata import run_file
from recordings.reader import parameters_of
from scenarios.errors import InputError

ARRAYS = [f.name for f in fields(Recording) if f.name != "channels"]


def assert_same(one: Recording, other: Recording) -> None:
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)
    assert one.channels.keys() == other.channels.keys()
    for name, values in one.channels.items():
        np.testing.assert_array_equal(values, other.channels[name], err_msg=name)


def stacked(run: Any, *names: str) -> np.ndarray:
    return np.stack([run.block[name] for name in names], axis=1)


def test_recording_of_a_run(tmp_path: Path, run: Any) -> None:
    run.write(tmp_path / "r.parquet")
    recording = read_recording(tmp_path / "r.parquet")
    np.testing.assert_array_equal(recording.time_s, run.block["time_s"])
    np.testing.assert_array_equal(recording.mag_nT, stacked(run, "mag_x_nT", "mag_y_nT", "mag_z_nT"))
    np.testing.assert_array_equal(recording.att_q, stacked(run, "att_qw", "att_qx", "att_qy", "att_qz"))
    np.testing.assert_array_equal(recording.current_A, stacked(run, "current_1_A", "current_2_A"))
    assert recording.phase.tolist() == run.block["phase"].tolist()
    assert recording.array_mag_nT is None
    assert recording.channels == {}


@pytest.mark.parametrize("sensors", [1, 4])
def test_labels_are_whole(tmp_path: Path, make_run: Any, sensors: int) -> None:
    make_run(sensors=sensors).write(tmp_path / "r.parquet")
    recording, truth = read_run(tmp_path / "r.parquet")
    assert tuple(truth.effects) == ("soft_iron", "hard_iron", "white_noise")
    measured = recording.mag_nT if sensors == 1 else recording.array_mag_nT
    assert np.abs(truth.field_nT + sum(truth.effects.values()) - measured).max() < 1e-6
    assert truth.q.shape == (400, 4)
    assert truth.pos_enu_m.shape == (400, 3)
    assert truth.parameters == {"hard_iron": {"x_nT": 300.0}}


def test_array_of_sensors(tmp_path: Path, make_run: Any) -> None:
    run = make_run(sensors=4, motors=0)
    run.write(tmp_path / "r.parquet")
    recording = read_recording(tmp_path / "r.parquet")
    assert recording.array_mag_nT.shape == (4, 400, 3)
    np.testing.assert_array_equal(recording.array_mag_nT[2], stacked(run, "mag3_x_nT", "mag3_y_nT", "mag3_z_nT"))
    np.testing.assert_array_equal(recording.mag_nT, recording.array_mag_nT[0])
    assert recording.current_A is None


def test_dataset_directory_by_run_number(tmp_path: Path, make_run: Any, scenario: dict[str, Any]) -> None:
    runs = [make_run(seed=i) for i in range(2)]
    open_dataset_for_writing(tmp_path, scenario, 7, 2, runs[0].table)
    runs[0].write(run_path(tmp_path, 0), run=0)
    with pytest.raises(InputError, match="run 1 is not there yet"):
        read_recording(tmp_path, run=1)
    runs[1].write(run_path(tmp_path, 1), run=1)
    finish_dataset(tmp_path)
    np.testing.assert_array_equal(read_recording(tmp_path, run=1).time_s, runs[1].block["time_s"])
    recording, truth = read_run(tmp_path, run=1)
    np.testing.assert_array_equal(recording.mag_nT[:, 0], runs[1].block["mag_x_nT"])
    np.testing.assert_array_equal(truth.field_nT[:, 2], runs[1].block["true_field_z_nT"])
    with pytest.raises(InputError, match=r"no run 2 \(it has runs 0 to 1\)"):
        read_recording(tmp_path, run=2)


def test_a_dataset_of_one_run_has_that_alone(tmp_path: Path, make_run: Any, scenario: dict[str, Any]) -> None:
    open_dataset_for_writing(tmp_path, scenario, 7, 1, make_run(seed=0).table)
    with pytest.raises(InputError, match=r"no run 1 \(it has run 0 alone\)"):
        read_recording(tmp_path, run=1)


@pytest.mark.parametrize("suffix", [".parquet", ".csv"])
@pytest.mark.parametrize("sensors", [1, 2])
def test_recording_written_for_others_holds_no_truth(tmp_path: Path, make_run: Any, suffix: str, sensors: int) -> None:
    run = make_run(sensors=sensors)
    run.write(tmp_path / "r.parquet")
    recording = replace(read_recording(tmp_path / "r.parquet"), channels={"rod_A_m2": np.linspace(0, 1, 400)})
    out = tmp_path / f"recording{suffix}"
    write_recording(recording, out)
    assert b"true_" not in out.read_bytes()
    assert b"effect_" not in out.read_bytes()
    assert_same(read_recording(out), recording)
    with pytest.raises(InputError, match="holds no truth"):
        read_run(out)


def test_recording_with_only_the_field(tmp_path: Path) -> None:
    recording = Recording(time_s=np.arange(30.0), mag_nT=1e3 * np.arange(90.0).reshape(30, 3))
    write_recording(recording, tmp_path / "r.parquet")
    assert_same(read_recording(tmp_path / "r.parquet"), recording)
    write_recording(recording, tmp_path / "r.csv")
    lines = (tmp_path / "r.csv").read_text().splitlines()
    assert lines[:2] == ["time_s,mag_x_nT,mag_y_nT,mag_z_nT", "0,0,1000,2000"]


@pytest.mark.parametrize("suffix", [".parquet", ".csv", ".CSV"])
@pytest.mark.parametrize("word", ["a,b", 'say "a"', "a\nb", "naïve"])
def test_words_that_a_table_must_quote(word: str, suffix: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    phase = np.where(np.arange(20) < 9, "spiral", word)
    channels = {} if "\n" in word else {f"wheel, {word}": np.arange(20.0)}
    recording = Recording(np.arange(20.0), 3e4 * rng.standard_normal((20, 3)), phase=phase, channels=channels)
    write_recording(recording, tmp_path / f"r{suffix}")
    if "\n" in word and suffix != ".parquet":
        assert '"a\nb"' in (tmp_path / f"r{suffix}").read_text()
    else:
        assert_same(read_recording(tmp_path / f"r{suffix}"), recording)


def test_recording_written_under_a_strange_suffix(tmp_path: Path) -> None:
    recording = Recording(time_s=np.arange(3.0), mag_nT=np.zeros((3, 3)))
    with pytest.raises(InputError, match=r"use \.parquet or \.csv"):
        write_recording(recording, tmp_path / "r.mat")
    assert list(tmp_path.iterdir()) == []


def test_cut_off_run(tmp_path: Path, run: Any) -> None:
    path = tmp_path / "r.parquet"
    run.write(path)
    path.write_bytes(path.read_bytes()[:-100])
    for read in (read_recording, read_run):
        with pytest.raises(InputError, match=r"r\.parquet: is cut off or damaged"):
            read(path)


def test_directory_that_is_no_dataset(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"dataset\.json: no such file"):
        read_recording(tmp_path)


def test_a_run_that_is_missing_is_not_called_damaged(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"run-00000\.parquet: no such file"):
        run_file(tmp_path / "run-00000.parquet", 0)


@pytest.mark.parametrize(
    "text", [b"{", b"[]", b"\xff", b'{"seed": "seven"}', b'{"parameters": {"field_enu_nT": [1, 2]}}']
)
def test_metadata_that_is_damaged(tmp_path: Path, run: Any, text: bytes) -> None:
    """The recording does not need it; who asks for the field or the truth is told."""
    run.write(tmp_path / "r.parquet")
    table = pq.read_table(tmp_path / "r.parquet")
    pq.write_table(table.replace_schema_metadata({"magbench": text}), tmp_path / "damaged.parquet")
    assert_same(read_recording(tmp_path / "damaged.parquet"), read_recording(tmp_path / "r.parquet"))
    with pytest.raises(InputError, match="metadata 'magbench'"):
        parameters_of(tmp_path / "damaged.parquet")
    with pytest.raises(InputError, match="metadata 'magbench'"):
        read_run(tmp_path / "damaged.parquet")


@pytest.mark.parametrize(
    ("name", "cells", "words"),
    [
        ("mag_y_nT", None, "no column mag_y_nT"),
        ("mag_y_nT", ["?"] * 400, "mag_y_nT: holds '\\?'"),
        ("mag_y_nT", [datetime.date(2026, 1, 1)] * 400, "mag_y_nT: holds date32"),
        ("gyro_x_rad_s", [b"x"] * 400, "gyro_x_rad_s: holds binary"),
        ("att_qz", [math.inf] * 400, "att_qz: 400 of 400 values are missing or infinite"),
        ("mag_x_nT", [1e300] * 400, "mag_x_nT: 400 of 400 values are missing or infinite"),
        ("time_s", [0.0] * 400, "time_s: row 2 repeats the time 0.0, as do 398 more"),
        ("time_s", [1e-12 * i for i in range(400)], "time_s: row 2 comes 1e-12 s after the last"),
    ],
)
def test_our_own_file_passes_the_checks_of_every_log(
    tmp_path: Path, run: Any, name: str, cells: list[Any] | None, words: str
) -> None:
    run.write(tmp_path / "r.parquet")
    table = pq.read_table(tmp_path / "r.parquet")
    metadata = table.schema.metadata
    table = table.drop_columns([name])
    table = table if cells is None else table.append_column(name, pa.array(cells))
    pq.write_table(table.replace_schema_metadata(metadata), tmp_path / "changed.parquet")
    for read in (read_recording, read_run):
        with pytest.raises(InputError, match=words):
            read(tmp_path / "changed.parquet")


def test_decimals_are_numbers(tmp_path: Path, run: Any) -> None:
    run.write(tmp_path / "r.parquet")
    table = pq.read_table(tmp_path / "r.parquet")
    metadata, cells = table.schema.metadata, [decimal.Decimal("1.25") * i for i in range(400)]
    table = table.drop_columns(["temperature_degC"]).append_column("temperature_degC", pa.array(cells))
    pq.write_table(table.replace_schema_metadata(metadata), tmp_path / "changed.parquet")
    recording, _ = read_run(tmp_path / "changed.parquet")
    np.testing.assert_array_equal(recording.temperature_degC, 1.25 * np.arange(400))


@pytest.mark.parametrize(
    ("name", "words"), [("true_qx", "no column true_qx"), ("effect_hard_iron_y_nT", "hard_iron_y")]
)
def test_truth_that_is_not_whole(tmp_path: Path, run: Any, name: str, words: str) -> None:
    run.write(tmp_path / "r.parquet")
    table = pq.read_table(tmp_path / "r.parquet")
    pq.write_table(table.drop_columns([name]), tmp_path / "changed.parquet")
    with pytest.raises(InputError, match=f"holds no truth, or not all of it.*{words}"):
        read_run(tmp_path / "changed.parquet")
