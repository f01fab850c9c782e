"""Logs as people have them, through the public functions: read without an option, with the right answer."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import magbench
from scenarios.errors import InputError

CASES = Path(__file__).parents[1] / "recordings" / "cases"
STRENGTH_NT = 48_000.0
OFFSET_NT = np.array([12_000.0, -8_000.0, 25_000.0])
COUNTS_A_NT = 6842 / 1e5
SIGMAS = 3.5
"""Claimed standard deviations within which the offset lies; of 70 components one beyond is a chance of 3 %."""
SAME = [
    *("base", "bom", "iso_z", "iso_space", "trailing_comma", "epoch_ms", "decimal_comma"),
    *("sep_line", "comments", "units_row", "utf16", "german_date", "clock", "no_time"),
    *("iso_seconds_only", "dup_times", "one_time_back", "time_back", "micros_wrap", "nan_some", "dash_some"),
    *("cut_last_line", "sentinel99999", "sparse_mag", "held_8hz", "interleaved", "imu_ok"),
]
TOLD = {
    "no_time.csv": "no time was found",
    "bare_magneto.txt": "no time was found",
    "iso_seconds_only.csv": "540 rows repeat a time",
    "dup_times.csv": "repeat a time",
    "one_time_back.csv": "1 row is out of order",
    "time_back.csv": "set back once, by 19.9 s",
    "micros_wrap.csv": "wraps once, as 32-bit microseconds do",
    "nan_some.csv": "6 of 600 rows have no field",
    "dash_some.csv": "6 of 600 rows have no field",
    "cut_last_line.csv": "the last line is cut off",
    "sparse_mag.csv": "600 of 6000 rows: these are the samples",
    "interleaved.csv": "the magnetometer's lines are those of MAG",
    "motioncal.txt": "(uT, by the name)",
    "level_2d.csv": "x and y alone were measured",
    "raw_lis3mdl.csv": "counts of unknown unit",
    "huge_hard_iron_ut.csv": "x_uT, y_uT, z_uT (uT, by the name)",
}


def sigmas_off(name: str, offset: np.ndarray) -> float:
    found = magbench.calibrate(CASES / name, STRENGTH_NT, with_="ellipsoid")
    assert found.covariance is not None, found.status
    return float(np.max(np.abs(found.offset_nT - offset) / np.sqrt(np.diag(found.covariance)[:3])))


@pytest.mark.parametrize("name", [*(f"{one}.csv" for one in SAME), "whitespace.txt", "bare_magneto.txt"])
def test_the_offset_is_within_the_claimed_interval(name: str) -> None:
    assert sigmas_off(name, OFFSET_NT) < SIGMAS


def test_the_unit_is_that_of_the_name_whatever_the_hard_iron() -> None:
    assert sigmas_off("huge_hard_iron_ut.csv", np.array([40_000.0, -90_000.0, 583_000.0])) < SIGMAS


def test_counts_stay_counts_and_need_a_unit_where_nT_count() -> None:
    found = magbench.calibrate(CASES / "raw_lis3mdl.csv", STRENGTH_NT, with_="ellipsoid")
    assert found.recording.origin.unit == "count"
    np.testing.assert_allclose(found.offset_nT, COUNTS_A_NT * OFFSET_NT, atol=5.0)
    with pytest.raises(InputError, match="counts of unknown unit"):
        magbench.bound(CASES / "raw_lis3mdl.csv", field_strength_nT=STRENGTH_NT)


@pytest.mark.parametrize(("name", "words"), TOLD.items(), ids=TOLD)
def test_what_was_guessed_or_mended_is_told(name: str, words: str) -> None:
    found = magbench.inspect(CASES / name)
    assert any(words in str(one.value) for one in found.findings if one.name == "reading")
    gaps = [gap["length_s"] for one in found.findings if one.name == "gaps" for gap in one.value]
    assert max(gaps, default=0.0) < 1.0


@pytest.mark.parametrize("name", ["no_time.csv", "bare_magneto.txt"])
def test_a_method_that_needs_times_says_so(name: str) -> None:
    found = magbench.calibrate(CASES / name, STRENGTH_NT, with_="ukf")
    assert found.status.kind == "not_applicable"
    assert "times" in found.status.reason


def test_place_and_date_give_the_field() -> None:
    reading = magbench.Reading(place="47.4,8.5", date="2024-05-01")
    found = magbench.calibrate(CASES / "base.csv", reading=reading)
    assert found.reference.strength_nT == pytest.approx(48_300, abs=300)
    with pytest.raises(InputError, match="date"):
        magbench.calibrate(CASES / "base.csv", reading=magbench.Reading(place="47.4,8.5", date="2040-05-01"))
