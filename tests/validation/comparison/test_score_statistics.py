"""Every figure of a comparison against plain numpy."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest
from scipy.stats import chi2

from tests.validation.comparison.example import table_of
from validation.comparison.score_statistics import reference_row, score_statistics
from validation.comparison.statistics import Interval, rate
from validation.comparison.trial_table import TrialTable

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


def claims(inside: list[float | None], squares: list[float | None]) -> TrialTable:
    """One calibrator's claims, trial by trial, and the raw measurement's error alone."""
    n, held = len(inside), dict[str, list[object]]()
    held["point"], held["run"], held["seed"] = [0] * 2 * n, [k // 2 for k in range(2 * n)], [0] * 2 * n
    held["calibrator"] = ["one", "uncorrected"] * n
    held["status"], held["reason"] = ["ok"] * 2 * n, [""] * 2 * n
    held["offset_error_nT"] = [1.0, 2.0] * n
    for name, values in (("offset_inside_95", inside), ("offset_nees", squares)):
        held[name] = [cell for value in values for cell in (value, None)]
    return TrialTable(pa.table(held), {})


def test_a_claim_is_a_rate_or_a_mean_over_the_trials_with_a_claim():
    table = claims([1.0, 1.0, 0.0, None], [2.0, 4.0, 6.0, None])
    found = {(one.calibrator, one.score.name): one for one in score_statistics(table, "uncorrected")}
    inside, squares = found["one", "offset_inside_95"], found["one", "offset_nees"]
    assert inside.found == rate(2, 3)
    assert squares.found.value == pytest.approx(4.0)
    assert squares.found.low == pytest.approx(3 * 12.0 / chi2.isf(0.025, 9))
    assert inside.ratio is squares.ratio is None  # no errors
    assert found["one", "offset_error"].ratio == Interval(0.5, 0.5, 0.5)
    assert found["one", "offset_error"].trials == inside.trials == 4
    assert ("uncorrected", "offset_nees") not in found  # given in no trial


def test_a_reference_without_error_gives_no_ratio():
    table = table_of({"one": ONE, "other": np.r_[0.0, OTHER[1:]], "uncorrected": ONE})
    assert next(score_statistics(table, "other")).ratio is None


def test_statistics_of_every_point_are_of_its_own_trials():
    table = table_of({"one": ONE, "uncorrected": ONE}, {"one": 2 * ONE, "uncorrected": ONE}, sweep=[1.0, 2.0])
    assert [(one.point, one.found.value) for one in score_statistics(table) if one.calibrator == "one"] == [
        *((0, 21.0), (1, 42.0))
    ]
