"""Time stamps with jitter and gaps of known size."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.arrays import Array
from tests.validation.inspection.recordings import FIELD_ENU_NT, RATE_HZ, log_of, moved, noise, one
from validation.inspection.finding import Finding
from validation.inspection.timing import find_gaps, in_seconds, timing_findings

SAMPLES = 3000
TIME_S = np.arange(SAMPLES) / RATE_HZ


def findings(time_s: Array, **columns: Array) -> list[Finding]:
    return timing_findings(log_of(time_s, noise(len(time_s), 5.0) + 20_000.0, **columns))


@pytest.mark.parametrize(("share", "level"), [(0.01, "ok"), (0.1, "note"), (0.3, "warning")])
def test_jitter_of_known_size(share: float, level: str) -> None:
    """Independent errors of sigma on each stamp make intervals that deviate by sqrt(2) sigma."""
    sigma_s = share / RATE_HZ
    bounded = np.clip(np.random.default_rng(0).normal(0, sigma_s, SAMPLES), -2 * sigma_s, 2 * sigma_s)
    found = one(findings(np.sort(TIME_S + bounded)), "jitter")
    assert found.value == pytest.approx(np.sqrt(2) * bounded.std(), rel=0.15)
    assert found.level == level
    assert ("irregular" in found.text) == (level == "warning")


def test_an_exact_clock_has_no_jitter() -> None:
    found = one(findings(TIME_S), "jitter")
    assert found.text == "The interval is constant."
    assert one(findings(TIME_S), "interval").value == pytest.approx(1 / RATE_HZ)


def test_rounded_stamps_are_told_from_jitter() -> None:
    """Stamps of 37 Hz in whole milliseconds: 27 and 28 ms in turn."""
    found = one(findings(np.round(np.arange(SAMPLES) / 37, 3)), "jitter")
    assert "rounding to 1 ms" in found.text
    assert found.level == "ok"


def test_samples_that_are_missing_are_no_rounding() -> None:
    """One sample in ten left out: intervals of 20 and of 40 ms."""
    found = one(findings(np.delete(TIME_S, slice(5, None, 10))), "jitter")
    assert "rounding" not in found.text
    assert found.level == "warning"


def test_gaps_are_where_samples_were_left_out() -> None:
    keep = np.r_[0:500, 600:2000, 2025:SAMPLES]
    gaps = find_gaps(TIME_S[keep])
    assert [gap.after_s for gap in gaps] == pytest.approx([TIME_S[499], TIME_S[1999]])
    assert [gap.length_s for gap in gaps] == pytest.approx([101 / RATE_HZ, 26 / RATE_HZ])
    found = one(findings(TIME_S[keep]), "gaps")
    assert found.level == "warning"
    assert found.text == "2 gaps, 2.54 s together; the longest, 2.02 s, begins at 9.98 s."
    assert one(findings(TIME_S), "gaps").value == []


def test_the_longest_of_many_gaps_are_listed_in_order_of_time() -> None:
    """Of 29 gaps that grow from 11 to 39 rows the last 20."""
    lengths = np.arange(10, 40)
    step = np.full(SAMPLES, 1 / RATE_HZ)
    step[100 * np.arange(30)] = lengths / RATE_HZ
    found = one(findings(np.cumsum(step)), "gaps")
    assert [gap["length_s"] for gap in found.value] == pytest.approx((lengths[10:] / RATE_HZ).tolist())
    assert found.text.startswith("29 gaps")


def test_a_clock_that_steps_back() -> None:
    stamps = np.r_[TIME_S[:2000], TIME_S[1900:2900]]
    found = one(findings(stamps), "order")
    assert found.value == {"missing": 0, "repeated": 0, "decreasing": 1}
    assert "the first in row 2001" in found.text
    assert "cut the file" in found.text
    assert found.level == "warning"


def test_missing_and_repeated_stamps_are_counted() -> None:
    stamps = TIME_S.copy()
    stamps[[10, 20]] = np.nan
    stamps[100] = stamps[99]
    assert one(findings(stamps), "order").value == {"missing": 2, "repeated": 1, "decreasing": 0}


def test_few_samples_are_said_to_be_few() -> None:
    assert one(findings(TIME_S[:50]), "samples").level == "note"
    assert one(findings(TIME_S), "samples").text == "3000 samples over 60 s."
    assert one(findings(np.zeros(0)), "samples").value == 0


@pytest.mark.parametrize("factor", [1.0, 1e3])
def test_where_a_gyro_tells_the_unit_the_stamps_are_made_seconds(factor: float) -> None:
    motion = moved()
    mag_nT = motion.body(FIELD_ENU_NT)
    log, found = in_seconds(log_of(factor * motion.time_s, mag_nT, gyro=motion.rate_rad_s))
    assert [one.level for one in found] == ([] if factor == 1.0 else ["warning"])
    np.testing.assert_allclose(log.columns["time_s"], motion.time_s, rtol=1e-12)


def test_where_the_field_alone_doubts_the_unit_they_stay() -> None:
    motion = moved()
    log, found = in_seconds(log_of(1e3 * motion.time_s, motion.body(FIELD_ENU_NT)))
    assert [one.level for one in found] == ["note"]
    np.testing.assert_array_equal(log.columns["time_s"], 1e3 * motion.time_s)
