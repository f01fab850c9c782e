"""The logs of the assessment's bench are what they say, and its shares count what they name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.assessment.bench import Judged, area, rows_of, table
from benchmarks.assessment.logs import log_of

GOOD = Judged(0, "ellipsoid", "ok", True, 0.1, 0.1, 0.5, True, "good", "high", (("yes", True), ("no", False)), ("a",))


def test_a_log_is_the_same_for_its_seed_and_another_for_the_next() -> None:
    assert np.array_equal(log_of(3).recording.mag_nT, log_of(3).recording.mag_nT)
    assert not np.array_equal(log_of(3).recording.mag_nT[:5], log_of(4).recording.mag_nT[:5])


@pytest.mark.parametrize("seed", range(4))
def test_the_true_calibration_of_a_sound_log_has_no_heading_error_and_leaves_the_noise(seed: int) -> None:
    log = log_of(seed, "")
    matrix = np.linalg.inv(log.soft)
    assert log.heading_rms_deg(log.offset_nT, matrix) < 1e-9
    strength = np.linalg.norm((log.recording.mag_nT - log.offset_nT) @ matrix.T, axis=1)
    assert np.std(strength) < 0.01 * np.linalg.norm(log.world_nT)


def test_an_offset_error_turns_the_heading_by_its_share_of_the_horizontal_field() -> None:
    log = replace(log_of(1, ""), soft=np.eye(3))
    level = float(np.hypot(*log.world_nT[:2]))
    error = log.heading_rms_deg(log.offset_nT + np.array([0.01 * level, 0.0, 500.0]), np.eye(3))
    assert error == pytest.approx(np.degrees(0.01) / np.sqrt(2.0), rel=0.01)


def test_a_wrong_yes_and_an_interval_that_misses_are_counted() -> None:
    missed = replace(GOOD, rank=0.99, inside=False, answers=(("yes", False), ("no", False)))
    figures = {row.what: row.value for row in rows_of([GOOD, missed])}
    assert figures["interval holds, at least"] == 0.5
    assert figures["wrong yes"] == 0.5
    assert figures["wrong no"] == 0.0
    assert figures["good told from bad, area"] is None
    assert any("0.500" in line for line in table([GOOD, missed]))


def test_the_area_is_the_probability_that_the_lower_is_lower() -> None:
    assert area([1.0, 2.0], [3.0]) == 1.0
    assert area([1.0, 3.0], [2.0, 3.0]) == pytest.approx(0.625)
    assert area([], [1.0]) is None
