"""Streams of several rates at a magnetometer's times: analytic signals, with the error bounds of theory."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from recordings import read_recording
from recordings.streams import (
    MAX_GAP_INTERVALS,
    Interpolation,
    MergedStreams,
    RemovedRows,
    Stream,
    covered,
    interpolated,
    merge,
    ordered_rows,
)
from scenarios.arrays import Array

QUATERNION = ("att_qw", "att_qx", "att_qy", "att_qz")


def magnetometer(rate_hz: float = 50.0, duration_s: float = 10.0, start_s: float = 0.0) -> Stream:
    """A field that turns once in ten seconds."""
    time_s = start_s + np.arange(round(duration_s * rate_hz) + 1) / rate_hz
    turn = 2 * np.pi * 0.1 * time_s
    return Stream(time_s, {"mag_x_nT": 3e4 * np.cos(turn), "mag_y_nT": 3e4 * np.sin(turn), "mag_z_nT": -4e4 + turn})


def clock(rate_hz: float, duration_s: float = 10.0, phase_s: float = 0.0) -> Array:
    """Times from phase_s to the end of the magnetometer's and beyond."""
    return phase_s + np.arange(math.ceil(duration_s * rate_hz) + 2) / rate_hz


def merged(time_s: Array, values: Any, how: Interpolation = Interpolation.LINEAR, **more: Any) -> MergedStreams:
    """One column beside the magnetometer's."""
    return merge(magnetometer(), {"other": Stream(time_s, {"x": np.asarray(values)}, {"x": how}, **more)})


def quaternions(axis: Array, angle_rad: Array) -> Array:
    """Turns (n,) about one axis: (n, 4), w x y z."""
    return np.column_stack([np.cos(angle_rad / 2), np.sin(angle_rad / 2)[:, None] * axis])


def angle_between(one: Array, other: Array) -> Array:
    """The turn in rad from one attitude (n, 4) to another: 4 asin(|q - p| / 2) of the nearer sign."""
    chord = np.minimum(np.linalg.norm(one - other, axis=1), np.linalg.norm(one + other, axis=1))
    return 4 * np.arcsin(chord / 2)


def attitude(time_s: Array, q: Array, how: Interpolation) -> Stream:
    return Stream(time_s, dict(zip(QUATERNION, q.T, strict=True)), dict.fromkeys(QUATERNION, how))


def test_the_magnetometer_stays_as_measured() -> None:
    own = magnetometer()
    found = merge(own, {"slow": Stream(clock(7.0), {"x": np.sin(clock(7.0))})})
    assert list(found.columns) == ["time_s", "mag_x_nT", "mag_y_nT", "mag_z_nT", "x"]
    np.testing.assert_array_equal(found.columns["time_s"], own.times_s)
    for name, values in own.columns.items():
        np.testing.assert_array_equal(found.columns[name], values)
    assert found.notes == ()


def test_sine_sampled_at_7_hz_is_within_the_bound_of_linear_interpolation() -> None:
    """h^2 / 8 max|f''|, which the middle between two samples at a crest comes near."""
    rate_hz, frequency_hz = 7.0, 0.5
    time_s, omega = clock(rate_hz), 2 * np.pi * frequency_hz
    found = merged(time_s, np.sin(omega * time_s)).columns
    error = np.abs(found["x"] - np.sin(omega * found["time_s"])).max()
    bound = (1 / rate_hz) ** 2 / 8 * omega**2
    assert 0.9 * bound < error <= bound


def test_noise_of_a_slow_stream_falls_as_the_weights_say() -> None:
    """Variance ((1 - u)^2 + u^2) s^2, whose mean over u is 2/3."""
    rng, time_s = np.random.default_rng(2), np.arange(40_000.0)
    at_s = rng.uniform(0, time_s[-1], 100_000)
    found = interpolated(at_s, time_s, rng.standard_normal((len(time_s), 1)), Interpolation.LINEAR)
    assert np.var(found) == pytest.approx(2 / 3, rel=0.02)


def test_rotation_at_a_constant_rate_is_exact() -> None:
    axis, rate_rad_s = np.array([0.6, -0.48, 0.64]), 1.3
    time_s = clock(7.0)
    signs = np.where(np.random.default_rng(3).random(len(time_s)) < 0.5, -1.0, 1.0)[:, None]
    stream = attitude(time_s, signs * quaternions(axis, rate_rad_s * time_s), Interpolation.SLERP)
    found = merge(magnetometer(), {"attitude": stream}).columns
    q = np.column_stack([found[name] for name in QUATERNION])
    assert angle_between(q, quaternions(axis, rate_rad_s * found["time_s"])).max() < 1e-14
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1, atol=1e-15)


@pytest.mark.parametrize("theta", [0.05, 0.3, 1.0])
def test_chord_is_within_its_bound_of_the_arc(theta: float) -> None:
    axis, at = np.array([0.0, 0.6, 0.8]), np.linspace(0, 1, 1001)
    nodes = quaternions(axis, np.array([0.0, theta]))
    chord, arc = (
        interpolated(at, np.array([0.0, 1.0]), nodes, how) for how in (Interpolation.CHORD, Interpolation.SLERP)
    )
    assert 0.95 * 0.004 * theta**3 < angle_between(chord, arc).max() < 0.0041 * theta**3


def test_attitudes_of_any_motion_as_scipy_carries_them() -> None:
    rng = np.random.default_rng(8)
    time_s = np.cumsum(rng.uniform(0.05, 0.3, 60))
    q = rng.standard_normal((60, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    at_s = rng.uniform(time_s[0], time_s[-1], 500)
    expected = Slerp(time_s, Rotation.from_quat(q, scalar_first=True))(at_s).as_quat(scalar_first=True)
    assert angle_between(interpolated(at_s, time_s, q, Interpolation.SLERP), expected).max() < 1e-12


def test_equal_neighbours_and_a_single_attitude() -> None:
    q = np.tile([0.5, 0.5, -0.5, 0.5], (3, 1))
    at_s = np.linspace(-1, 3, 9)
    for nodes in (q, q[:1]):
        found = interpolated(at_s, np.arange(len(nodes)) * 1.0, nodes, Interpolation.SLERP)
        np.testing.assert_array_equal(found, np.tile(q[0], (9, 1)))


@pytest.mark.parametrize(
    ("how", "turn"), [(Interpolation.ANGLE_DEG, 360.0), (Interpolation.ANGLE_RAD, 2 * np.pi)], ids=["deg", "rad"]
)
def test_heading_does_not_sweep_back_at_a_whole_turn(how: Interpolation, turn: float) -> None:
    time_s = clock(5.0)
    found = merged(time_s, (0.4 * turn * time_s) % turn, how).columns
    np.testing.assert_allclose(found["x"], 0.4 * turn * found["time_s"], atol=1e-10)


def test_steps_are_never_smeared() -> None:
    time_s = clock(5.0)
    level = np.floor(time_s) % 3
    nearest, held = (merged(time_s, level, how).columns for how in (Interpolation.NEAREST, Interpolation.HELD))
    assert set(nearest["x"]) == set(held["x"]) == {0.0, 1.0, 2.0}
    at_s = held["time_s"]
    clear = np.abs(at_s * 5 - np.round(at_s * 5)) > 1e-6
    np.testing.assert_array_equal(held["x"][clear], (np.floor(np.floor(at_s * 5) / 5 + 1e-9) % 3)[clear])
    halfway = np.abs(at_s * 5 % 1 - 0.5) < 1e-6
    away = ~halfway
    np.testing.assert_array_equal(nearest["x"][away], (np.floor(np.round(at_s * 5) / 5 + 1e-9) % 3)[away])


def test_flight_modes_last_until_the_next() -> None:
    modes = Stream(
        np.array([1.0, 4.0]),
        {"phase": np.array(["climb", "survey"]), "mode": np.array([3, 7])},
        dict.fromkeys(("phase", "mode"), Interpolation.HELD),
        max_gap_intervals=math.inf,
    )
    found = merge(magnetometer(), {"modes": modes})
    at_s = found.columns["time_s"]
    expected = np.select([at_s < 1, at_s < 4], ["", "climb"], "survey")
    np.testing.assert_array_equal(found.columns["phase"], expected)
    np.testing.assert_array_equal(found.columns["mode"], np.select([at_s < 1, at_s < 4], [np.nan, 3.0], 7.0))
    assert found.missing == {"phase": 50, "mode": 50}
    alone = merge(
        magnetometer(), {"modes": Stream(np.array([1.0]), {"m": np.array([3])}, {"m": Interpolation.HELD}, math.inf)}
    )
    assert alone.missing == {"m": 50}


@pytest.mark.parametrize("intervals", [4.0, 6.0])
def test_gap_is_bridged_up_to_the_limit(intervals: float) -> None:
    rate_hz = 5.0
    time_s = clock(rate_hz)
    time_s = time_s[(time_s < 2.0 + 1e-9) | (time_s > 2.0 + intervals / rate_hz - 1e-9)]
    found = merged(time_s, 2.0 + time_s)
    at_s, x = found.columns["time_s"], found.columns["x"]
    silent = (at_s > 2.0 + 1e-9) & (at_s < 2.0 + intervals / rate_hz - 1e-9)
    empty = silent if intervals > MAX_GAP_INTERVALS else np.zeros_like(silent)
    np.testing.assert_array_equal(np.isnan(x), empty)
    np.testing.assert_allclose(x[~empty], 2.0 + at_s[~empty], atol=1e-12)
    assert found.missing == ({"x": int(empty.sum())} if empty.any() else {})
    assert len(found.notes) == bool(empty.any())


def test_held_and_nearest_values_reach_a_part_of_a_gap() -> None:
    time_s = np.r_[np.arange(0, 2.01, 0.2), np.arange(8, 10.01, 0.2)]
    held, nearest = (merged(time_s, time_s, how).columns for how in (Interpolation.HELD, Interpolation.NEAREST))
    at_s = held["time_s"]
    clear = np.min(np.abs(at_s[:, None] - [2.5, 3.0, 7.5, 8.0]), axis=1) > 1e-6  # a limit itself is decided by rounding
    np.testing.assert_array_equal(np.isnan(held["x"])[clear], ((at_s > 3) & (at_s < 8))[clear])
    np.testing.assert_array_equal(np.isnan(nearest["x"])[clear], ((at_s > 2.5) & (at_s < 7.5))[clear])


def test_late_start_and_early_end_are_left_empty() -> None:
    time_s = np.arange(3.0, 7.01, 0.25)
    found = merged(time_s, np.ones(len(time_s)))
    at_s = found.columns["time_s"]
    np.testing.assert_array_equal(np.isnan(found.columns["x"]), (at_s < 3) | (at_s > 7))
    assert found.notes == (f"x: no value at {found.missing['x']} of 501 times",)


def test_stream_that_never_overlaps_is_left_out_and_counted() -> None:
    found = merged(np.arange(100.0, 110.0), np.ones(10))
    assert "x" not in found.columns
    assert found.missing == {"x": 501}
    assert "x" not in merged(np.array([]), np.array([])).columns
    assert "x" not in merged(clock(5.0), np.full(len(clock(5.0)), np.nan)).columns


def test_cells_without_a_value_are_no_samples() -> None:
    """A column that lacks every second value is carried as if those samples had not been taken."""
    time_s = clock(10.0)
    sparse = np.where(np.arange(len(time_s)) % 2, np.nan, time_s**2)
    every, second = merged(time_s, sparse), merged(time_s[::2], sparse[::2])
    np.testing.assert_array_equal(every.columns["x"], second.columns["x"])


@pytest.mark.parametrize(
    ("time_s", "kept", "removed"),
    [
        ([0.0, 1.0, 2.0, 3.0], [0, 1, 2, 3], RemovedRows()),
        ([0.0, 1.0, 1.0, 2.0], [0, 2, 3], RemovedRows(repeated=1)),
        ([0.0, 1.0, 0.5, 2.0, 3.0], [0, 2, 3, 4], RemovedRows(backwards=1)),
        ([0.0, 1.0, 99.0, 2.0, 3.0], [0, 1, 3, 4], RemovedRows(backwards=1)),
        ([7.0, 8.0, 0.0, 1.0, 2.0, 3.0], [2, 3, 4, 5], RemovedRows(backwards=2)),
        ([0.0, np.nan, 1.0, np.inf, 2.0], [0, 2, 4], RemovedRows(without_time=2)),
        ([], [], RemovedRows()),
    ],
    ids=["in order", "repeats", "back once", "ahead once", "clock reset", "no time", "nothing"],
)
def test_rows_out_of_time_are_removed_and_counted(time_s: list[float], kept: list[int], removed: RemovedRows) -> None:
    rows, found = ordered_rows(np.array(time_s))
    assert rows.tolist() == kept
    assert found == removed


@given(st.lists(st.integers(0, 12), max_size=10))
def test_the_fewest_rows_are_removed(times: list[int]) -> None:
    """As trying every subset finds."""
    rows, removed = ordered_rows(np.array(times, np.float64))
    assert np.all(np.diff(np.array(times)[rows]) > 0)
    assert len(rows) + removed.total == len(times)
    subsets = ([t for i, t in enumerate(times) if bits >> i & 1] for bits in range(2 ** len(times)))
    longest = max(len(part) for part in subsets if all(a < b for a, b in pairwise(part)))
    assert len(rows) == longest


def test_disorder_in_either_stream_is_counted() -> None:
    own = magnetometer()
    doubled = np.repeat(np.arange(len(own.times_s)), 1 + (np.arange(len(own.times_s)) % 100 == 7))
    twice = Stream(own.times_s[doubled], {name: values[doubled] for name, values in own.columns.items()})
    time_s = clock(5.0)
    time_s[20] = -1.0
    found = merge(twice, {"battery": Stream(time_s, {"current_1_A": time_s * 0 + 2})})
    assert found.removed == {"magnetometer": RemovedRows(repeated=5), "battery": RemovedRows(backwards=1)}
    np.testing.assert_array_equal(found.columns["mag_x_nT"], own.columns["mag_x_nT"])
    assert found.notes[0].startswith(
        "magnetometer: 5 rows removed: 0 without a time, 5 with a repeated time, 0 against"
    )
    assert np.all(found.columns["current_1_A"] == 2)


def test_several_magnetometers_on_their_own_times() -> None:
    one, other = magnetometer(50.0), magnetometer(20.0, start_s=0.013)
    slow = {"attitude": Stream(clock(10.0), {"x": clock(10.0)})}
    by_sensor = [merge(sensor, slow).columns for sensor in (one, other)]
    for sensor, found in zip((one, other), by_sensor, strict=True):
        np.testing.assert_array_equal(found["time_s"], sensor.times_s)
        np.testing.assert_allclose(found["x"], sensor.times_s, atol=1e-12)


def test_merged_streams_are_a_recording_like_a_file_with_empty_cells(tmp_path: Path) -> None:
    """The gaps of a file whose rows are merged, and a merge of its streams, give the same values."""
    own, every = magnetometer(), 7
    time_s = own.times_s[::every]
    axis = np.array([0.0, 0.0, 1.0])
    q = quaternions(axis, 0.4 * time_s)
    slow = {"temperature_degC": 20 + np.sin(time_s), "wheel_rad_s": time_s**2}
    streams = {"slow": Stream(time_s, slow), "attitude": attitude(time_s, q, Interpolation.CHORD)}
    found = merge(own, streams).columns
    cells: dict[str, Any] = {"time_s": own.times_s, **own.columns}
    for name, values in {**slow, **dict(zip(QUATERNION, q.T, strict=True))}.items():
        cells[name] = np.full(len(own.times_s), np.nan)
        cells[name][::every] = values
    pq.write_table(pa.table(cells), tmp_path / "log.parquet")
    recording = read_recording(tmp_path / "log.parquet")
    reached = own.times_s <= time_s[-1]
    np.testing.assert_array_equal(recording.temperature_degC[reached], found["temperature_degC"][reached])
    np.testing.assert_array_equal(recording.channels["wheel_rad_s"][reached], found["wheel_rad_s"][reached])
    np.testing.assert_allclose(recording.att_q[reached, 3], found["att_qz"][reached], atol=1e-15)
    assert np.isnan(found["temperature_degC"][~reached]).all()


@given(
    st.lists(st.floats(0.01, 1.0), min_size=1, max_size=20),
    st.sampled_from([how for how in Interpolation if how not in (Interpolation.SLERP, Interpolation.CHORD)]),
    st.integers(0, 2**32 - 1),
)
def test_at_its_own_times_a_stream_is_as_it_was(steps: list[float], how: Interpolation, seed: int) -> None:
    time_s = np.cumsum(steps)
    values = np.random.default_rng(seed).uniform(-1, 1, (len(steps), 1))
    np.testing.assert_allclose(interpolated(time_s, time_s, values, how), values, atol=1e-15)
    assert covered(time_s, time_s, how, 0.0).all()
    between = interpolated(np.linspace(-1, time_s[-1] + 1, 57), time_s, values, how)
    assert values.min() <= between.min() <= between.max() <= values.max()


@pytest.mark.parametrize(
    ("columns", "how", "words"),
    [
        ({"x": np.zeros(3)}, {}, "columns of other lengths"),
        ({"x": np.zeros(4)}, {"y": Interpolation.HELD}, "not there: y"),
        ({"x": np.array(["a"] * 4)}, {}, "x holds words"),
        ({"x": np.zeros(4)}, {"x": Interpolation.SLERP}, "needs the four columns"),
        ({name: np.zeros(4) for name in "wxyz"}, dict.fromkeys("wxy", Interpolation.CHORD), "needs the four columns"),
    ],
)
def test_stream_that_cannot_be_carried(columns: dict[str, Any], how: dict[str, Interpolation], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Stream(np.arange(4.0), columns, how)


@pytest.mark.parametrize("name", ["time_s", "mag_x_nT", "x"])
def test_column_of_two_streams(name: str) -> None:
    one, other = (Stream(np.arange(3.0), {column: np.zeros(3)}) for column in ("x", name))
    with pytest.raises(ValueError, match=f"the stream other has a column {name}, as does another"):
        merge(magnetometer(), {"one": one, "other": other})
