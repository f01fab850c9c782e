"""Each fault is found by its own screen, with the rows that were made faulty, and sound recordings have none."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from recordings import Recording
from scenarios.arrays import Array
from tests.validation.screening.tumbling import F_NT, OFFSET_NT, tumble
from validation.screening.fault import Fault
from validation.screening.screening import screen

SEEDS = range(5)
Change = Callable[[Array], None]


def faults(recording: Recording, change: Change) -> tuple[Fault, ...]:
    mag_nT = recording.mag_nT.copy()
    change(mag_nT)
    return screen(replace(recording, mag_nT=mag_nT)).faults


def only(recording: Recording, change: Change) -> Fault:
    (fault,) = faults(recording, change)
    return fault


def rounded(recording: Recording, step_nT: float) -> Recording:
    return replace(recording, mag_nT=step_nT * np.rint(recording.mag_nT / step_nT))


@pytest.mark.parametrize("step_nT", [0.1, 2.0, 60.0])
@pytest.mark.parametrize("seed", range(40))
def test_a_sound_recording_has_no_fault(seed: int, step_nT: float) -> None:
    assert screen(rounded(tumble(seed), step_nT)).faults == ()


@pytest.mark.parametrize("step_nT", [0.1, 2.0, 60.0])
@pytest.mark.parametrize("seed", SEEDS)
def test_an_axis_stuck_to_the_end(seed: int, step_nT: float) -> None:
    first = 150 + 37 * seed

    def stick(mag_nT: Array) -> None:
        mag_nT[first:, 2] = mag_nT[first - 1, 2]

    fault = only(rounded(tumble(seed), step_nT), stick)
    assert (fault.kind, fault.remedy) == ("stuck", "left out")
    assert fault.text.startswith("axis z is stuck at ")
    np.testing.assert_array_equal(fault.rows, np.arange(600) >= first)


def test_an_axis_stuck_for_stretches() -> None:
    def stick(mag_nT: Array) -> None:
        mag_nT[100:140, 0] = mag_nT[99, 0]
        mag_nT[300:330, 0] = mag_nT[299, 0]

    fault = only(tumble(3), stick)
    assert fault.kind == "stuck"
    assert fault.told.startswith("rows 101 to 140 and 301 to 330 were left out: axis x is stuck at ")


def test_an_axis_that_saturates_is_not_called_stuck() -> None:
    def cut(mag_nT: Array) -> None:
        np.clip(mag_nT, None, 60_000, out=mag_nT)

    fault = only(tumble(0, rows=3000, rate_hz=100), cut)
    assert fault.kind == "full_scale"
    assert "at 60000 nT" in fault.text


def test_the_whole_sensor_frozen() -> None:
    def freeze(mag_nT: Array) -> None:
        mag_nT[200:260] = mag_nT[199]

    fault = only(tumble(1), freeze)
    assert (fault.kind, fault.remedy) == ("frozen", "left out")
    np.testing.assert_array_equal(np.flatnonzero(fault.rows), np.arange(200, 260))


def test_a_held_sensor_gives_one_row_for_each_sample() -> None:
    recording = tumble(2, rows=3000, rate_hz=100)
    held = np.arange(3000) // 12 * 12
    found = screen(replace(recording, mag_nT=recording.mag_nT[held]))
    assert [fault.kind for fault in found.faults] == ["held"]
    np.testing.assert_array_equal(found.recording.time_s, recording.time_s[::12])
    assert "8.333 Hz" in found.faults[0].text


@pytest.mark.parametrize("value", [99_999.0, -999_990.0, 123_456.0])
def test_a_sentinel(value: float) -> None:
    at = [17, 18, 200, 401]

    def miss(mag_nT: Array) -> None:
        mag_nT[at, 1] = value

    fault = only(tumble(4), miss)
    assert (fault.kind, fault.remedy) == ("sentinel", "left out")
    np.testing.assert_array_equal(np.flatnonzero(fault.rows), at)


def test_rows_of_zeros_are_sentinels() -> None:
    def miss(mag_nT: Array) -> None:
        mag_nT[30:40] = 0.0

    fault = only(tumble(4), miss)
    assert fault.kind == "sentinel"
    assert fault.told.startswith("rows 31 to 40 were left out")


@pytest.mark.parametrize("counts_a_nT", [0.55, 0.7, 1.5])
@pytest.mark.parametrize("nT_a_count", [1.0, 6.8, 0.37])
@pytest.mark.parametrize("seed", SEEDS)
def test_counts_of_16_bits_that_wrap_are_unwrapped(seed: int, nT_a_count: float, counts_a_nT: float) -> None:
    """Rows that have not wrapped keep their values while they are most; else the offset differs by a whole turn."""
    recording = tumble(seed)
    counts = np.rint(recording.mag_nT * counts_a_nT)
    wrapped = (counts + 32_768) % 65_536 - 32_768
    assert (counts != wrapped).any()
    found = screen(replace(recording, mag_nT=nT_a_count * wrapped))
    assert {fault.kind for fault in found.faults} == {"wrapped"}
    assert all(fault.remedy == "unwrapped" and "16 bits" in fault.text for fault in found.faults)
    turns = (found.recording.mag_nT / nT_a_count - counts) / 65_536
    np.testing.assert_allclose(turns, np.tile(np.rint(turns[0]), (600, 1)), atol=1e-6)
    if counts_a_nT < 1:
        assert not np.rint(turns[0]).any()


def test_a_wrap_of_an_unknown_period_is_left_out() -> None:
    recording = tumble(1)
    wrapped = (recording.mag_nT + 60_000.0) % 120_000.0 - 60_000.0
    found = screen(replace(recording, mag_nT=wrapped))
    assert {(fault.kind, fault.remedy) for fault in found.faults} == {("wrapped", "left out")}
    sound: NDArray[np.bool_] = np.isclose(wrapped, recording.mag_nT).all(axis=1)
    assert not (found.keep & ~sound).any()
    assert found.keep.sum() > 0.9 * sound.sum()


@pytest.mark.parametrize("sign", [1, -1])
def test_two_axes_that_measure_the_same(sign: int) -> None:
    noise = np.random.default_rng(8).normal(0, 150, 600)

    def copy(mag_nT: Array) -> None:
        mag_nT[:, 1] = sign * mag_nT[:, 0] + noise

    fault = only(tumble(5), copy)
    assert (fault.kind, fault.remedy, fault.doubtful) == ("alike", "none", True)
    assert "axes x and y measure the same" in fault.text


def test_an_axis_that_is_not_wired() -> None:
    noise = np.random.default_rng(9).normal(40, 150, 600)

    def cut(mag_nT: Array) -> None:
        mag_nT[:, 0] = noise

    fault = only(tumble(5), cut)
    assert (fault.kind, fault.doubtful) == ("unwired", True)
    assert "axis x shows only noise" in fault.text


def test_a_level_turn_has_a_quiet_axis_that_is_wired() -> None:
    angle = np.linspace(0, 12, 600)
    field_nT = F_NT * np.column_stack([np.cos(angle), np.sin(angle), np.full(600, -0.5)])
    noise_nT = np.random.default_rng(3).normal(0, 150, (600, 3))
    assert screen(Recording(np.arange(600) / 10, field_nT + OFFSET_NT + noise_nT)).faults == ()


@pytest.mark.parametrize("seed", SEEDS)
def test_a_magnet_that_moved(seed: int) -> None:
    def move(mag_nT: Array) -> None:
        mag_nT[300:, 1] += 9_000.0

    fault = only(tumble(seed, rows=1200, rate_hz=20), move)
    assert (fault.kind, fault.remedy, fault.doubtful) == ("step", "none", True)
    assert re.search(r"axis y steps by [89]\d{3} nT", fault.text)
    assert "15 s after the first row" in fault.text


def test_a_new_attitude_between_rows_is_no_step() -> None:
    parts = [tumble(seed, rows=200, rate_hz=20).mag_nT for seed in range(6)]
    mag_nT = np.concatenate(parts)
    assert screen(Recording(np.arange(len(mag_nT)) / 20, mag_nT)).faults == ()


def test_poses_at_rest_have_no_fault() -> None:
    rng = np.random.default_rng(2)
    for _ in range(50):
        unit = rng.normal(size=(24, 3))
        unit /= np.linalg.norm(unit, axis=1, keepdims=True)
        assert screen(Recording(np.arange(24.0), F_NT * unit + OFFSET_NT)).faults == ()
