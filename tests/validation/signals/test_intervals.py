"""Neighbours and gaps of time stamps whose true interval is known."""

from __future__ import annotations

import numpy as np
import pytest

from validation.signals.intervals import gaps_after, usual_interval

TIME_S = np.r_[0.0:10.0:0.0123, 50.0:60.0:0.0123]
LAST_BEFORE = int(np.searchsorted(TIME_S, 20.0)) - 1


def test_a_pause_is_a_gap_and_jitter_is_none() -> None:
    jittered = TIME_S + np.random.default_rng(0).uniform(-0.002, 0.002, len(TIME_S))
    for time_s in (TIME_S, jittered):
        assert gaps_after(time_s).tolist() == [LAST_BEFORE]


def test_the_usual_interval_is_the_true_one_of_rounded_stamps() -> None:
    """The median interval of stamps rounded to a millisecond is 12 ms."""
    assert usual_interval(np.round(TIME_S, 3)) == pytest.approx(0.0123, rel=2e-3)


def test_a_single_stamp_has_no_interval() -> None:
    assert np.isnan(usual_interval(np.zeros(1)))
    assert len(gaps_after(np.zeros(1))) == 0
