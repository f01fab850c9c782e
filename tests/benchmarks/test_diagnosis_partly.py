"""The bench of effects in a part of the run: what it hides, and how it scores."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.diagnosis.partly import NOISE_NT, PARTLY, SHARE, Trial, f1, figures, made, trials


def test_a_window_is_scored_by_its_time() -> None:
    assert f1((10.0, 20.0), (10.0, 20.0)) == 1.0
    assert f1((10.0, 20.0), (15.0, 20.0)) == pytest.approx(2 * 5 / 15)
    assert f1((0.0, 5.0), (10.0, 20.0)) == f1(None, (10.0, 20.0)) == 0.0


def test_trials_are_told_apart_and_every_kind_is_there() -> None:
    some = list(trials(0, 1))
    assert len({trial.key for trial in some}) == len(some) == 80
    assert sum(trial.kind == "part" for trial in some) == 4 * len(PARTLY)


def test_what_is_hidden_acts_in_the_window_at_its_strength() -> None:
    loud, quiet, window, _ = made(Trial("part", "quadrotor", "motor_current", 3.0, 0))
    assert window is not None
    inside = (loud.time_s >= window[0]) & (loud.time_s < window[1])
    assert inside.mean() == pytest.approx(SHARE, abs=0.01)
    added = loud.mag_nT - quiet.mag_nT
    assert not added[~inside].any()
    assert np.sqrt((added[inside] ** 2).mean()) > NOISE_NT


def test_a_name_without_a_window_does_not_count_as_found() -> None:
    row = {"kind": "part", "hidden": "a", "window": (0.0, 1.0), "iron": 0.5, "names": [("a", [], "held-out", None)]}
    told = figures([row, {**row, "names": [("b", ["a"], "held-out", (0.0, 1.0))]}])["part"]
    assert (told["named"], told["f1_at_least_0.9"]) == (1.0, 0.5)
