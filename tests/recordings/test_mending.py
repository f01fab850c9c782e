"""Rows and clocks as loggers damage them: mended where the rest is enough, counted and told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from recordings.importer import RawColumns
from recordings.mending import mended
from scenarios.arrays import Array

N = 600
TIME_S = np.arange(N) / 10
ANGLE = np.linspace(0.0, 40.0, N)
FIELD = {
    "mag_x_nT": 4e4 * np.cos(ANGLE),
    "mag_y_nT": 4e4 * np.sin(ANGLE) * np.cos(0.3 * ANGLE),
    "mag_z_nT": 4e4 * np.sin(ANGLE) * np.sin(0.3 * ANGLE),
}


def raw(time_s: Array = TIME_S, **columns: Array) -> RawColumns:
    return RawColumns(Path("log.csv"), {"time_s": time_s, **FIELD, **columns})


def gap(missing: Array) -> Array:
    return np.where(missing, np.nan, FIELD["mag_y_nT"])


def test_a_sound_log_is_left_alone() -> None:
    log = raw()
    assert mended(log) is log


def test_rows_without_a_field_are_skipped_and_counted() -> None:
    found = mended(raw(mag_y_nT=gap(np.arange(N) % 100 == 0)))
    assert len(found.named["time_s"]) == N - 6
    assert found.origin.notes == ("6 of 600 rows have no field (empty or not a number) and were skipped",)


def test_of_a_slow_magnetometer_the_rows_with_a_value_are_the_samples() -> None:
    """The gyro is a mean around each sample: a linear rate stays, away from the ends."""
    found = mended(raw(mag_y_nT=gap(np.arange(N) % 10 != 0), gyro_x_rad_s=TIME_S))
    np.testing.assert_allclose(found.named["time_s"], TIME_S[::10])
    np.testing.assert_allclose(found.named["gyro_x_rad_s"][1:-1], TIME_S[::10][1:-1], atol=0.051)
    assert "60 of 600 rows: these are the samples" in found.origin.notes[0]


@pytest.mark.parametrize("period_s", [2**32 / 1e6, 2**16 / 1e3, 2**32 / 1e3])
def test_a_counter_that_wraps_goes_on(period_s: float) -> None:
    found = mended(raw((TIME_S + period_s - 30.0) % period_s))
    np.testing.assert_allclose(np.diff(found.named["time_s"]), 0.1, atol=1e-6)
    assert "wraps once" in found.origin.notes[0]


def test_a_clock_that_is_set_back_goes_on_by_the_usual_step() -> None:
    found = mended(raw(np.where(np.arange(N) < 300, TIME_S, TIME_S - 20.0)))
    np.testing.assert_allclose(found.named["time_s"], TIME_S, atol=1e-9)
    assert "set back once, by 19.9 s in row 301" in found.origin.notes[0]


def test_a_late_row_is_sorted() -> None:
    order = np.r_[0:250, 251:254, 250, 254:N]
    columns = {name: values[order] for name, values in FIELD.items()}
    found = mended(raw(TIME_S[order], **columns))
    np.testing.assert_array_equal(found.named["time_s"], TIME_S)
    np.testing.assert_array_equal(found.named["mag_x_nT"], FIELD["mag_x_nT"])
    assert "1 row is out of order" in found.origin.notes[0]


@pytest.mark.parametrize("start_s", [0.0, 0.3, 0.7])
def test_whole_seconds_are_spread_evenly(start_s: float) -> None:
    """To within a tenth of a second in every phase of the clock, the first and the last second included."""
    found = mended(raw(np.floor(TIME_S + start_s)))
    np.testing.assert_allclose(found.named["time_s"], TIME_S + start_s, atol=1e-9)
    assert "repeat a time" in found.origin.notes[0]


def test_a_pause_of_a_coarse_clock_stays() -> None:
    stamps = np.floor(TIME_S) + np.where(TIME_S >= 30, 100.0, 0.0)
    found = mended(raw(stamps))
    step_s = np.diff(found.named["time_s"])
    np.testing.assert_allclose(np.delete(step_s, 299), 0.1, atol=1e-9)
    assert step_s[299] == pytest.approx(100.1)


def test_copies_of_a_row_are_removed() -> None:
    rows = np.r_[0:100, 99, 99, 100:N]
    found = mended(raw(TIME_S[rows], **{name: values[rows] for name, values in FIELD.items()}))
    np.testing.assert_array_equal(found.named["time_s"], TIME_S)
    assert found.origin.notes == ("2 rows are copies of the previous row and were removed",)


def test_rows_in_memory_are_never_skipped_or_moved() -> None:
    log = RawColumns(Path("array"), {"time_s": TIME_S[::-1], **FIELD}, strict=True)
    assert mended(log) is log
