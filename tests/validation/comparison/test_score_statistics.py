"""Every figure of a comparison against plain numpy."""

from __future__ import annotations

import numpy as np
import pytest

from tests.validation.comparison.example import table_of
from validation.comparison.score_statistics import reference_row, score_statistics

ONE, OTHER = np.arange(1.0, 42.0), np.arange(2.0, 43.0)


def test_median_failures_and_ratio():
    table = table_of({"one": ONE, "other": OTHER, "uncorrected": 100 * ONE}, failing=["other"])
    found = {one.calibrator: one for one in score_statistics(table, "other")}
    assert found["one"].found.value == 21.0
    assert found["one"].ratio is not None
    assert found["one"].ratio.value == pytest.approx(float(np.median(ONE / OTHER)))
    assert found["other"].ratio is not None
    assert found["other"].ratio.value == 1.0
    assert (found["other"].failures, found["one"].failures, found["one"].trials) == (41, 0, 41)


def test_without_reference_or_with_one_that_fails_there_is_no_ratio():
    table = table_of({"one": ONE, "other": np.r_[OTHER[:-1], np.inf], "uncorrected": ONE})
    assert all(one.ratio is None for one in score_statistics(table))
    assert next(score_statistics(table, "other")).ratio is None


def test_half_without_estimate_is_an_infinite_median():
    table = table_of({"one": np.r_[ONE[:20], np.full(21, np.inf)], "uncorrected": ONE})
    assert next(score_statistics(table)).found.value == np.inf


def test_a_calibrator_without_any_estimate_has_a_row_with_its_failures_and_their_reason():
    table = table_of({"crash": np.full(9, np.inf), "good": np.ones(9), "uncorrected": np.ones(9)})
    crash, good, _ = score_statistics(table, "good")
    assert (crash.calibrator, crash.found.value, crash.failures, crash.reason) == ("crash", np.inf, 9, "it broke down")
    assert (good.failures, good.reason) == (0, "")


def test_the_reference_of_an_arrays_sensor_is_that_sensors():
    assert reference_row("ellipsoid", "sphere@3") == "ellipsoid@3"
    assert reference_row("ellipsoid", "sphere") == "ellipsoid"
