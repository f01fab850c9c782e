"""Ratios of scores to the bound."""

from __future__ import annotations

import numpy as np
import pytest

from calib import CALIBRATORS
from sim.scenario import load
from validation.bound.ratio import bound_ratio, knowledge_of, least_scores


def test_what_a_calibrator_is_told_follows_from_what_it_needs() -> None:
    assert knowledge_of("ellipsoid", attitude_free=True) == "norm"
    assert knowledge_of("vector_least_squares", attitude_free=False) == "vector"
    assert knowledge_of("vector_lm", attitude_free=False, eddy=True) == "vector+eddy"
    assert knowledge_of("mine", attitude_free=True) == "norm"
    assert knowledge_of("gyro_ml", attitude_free=True) == "norm+gyro"
    assert knowledge_of("gyro_accel_ml", attitude_free=True) == "norm+gyro+accel"
    assert knowledge_of("ellipsoid@2", attitude_free=True) is None
    assert {knowledge_of(name, attitude_free=True) for name, one in CALIBRATORS.items() if "array" in one.needs} == {
        None
    }


def test_the_least_offset_error_is_the_standard_s() -> None:
    least = least_scores(load("standard-full"), {"norm", "vector"})
    # flown: 3800 samples for 3600, and the first of them on the way into the motion
    assert least["norm", "offset_error_nT"] == pytest.approx(0.5592, rel=0.05)
    assert least["vector", "offset_error_nT"] == pytest.approx(0.2938, rel=0.05)
    assert least_scores(load("standard-full", ["effects.white_noise.std_nT=[0, 0, 0]"]), {"norm"}) == {}


def test_a_ratio_is_of_the_rms_over_trials_with_an_estimate() -> None:
    assert bound_ratio(np.array([3.0, np.nan, 4.0]), 2.5) == pytest.approx(np.sqrt(2.0))
    assert bound_ratio(np.array([np.nan]), 1.0) is None
    assert bound_ratio(np.ones(2), np.inf) is None
    assert bound_ratio(np.ones(2), None) is None
