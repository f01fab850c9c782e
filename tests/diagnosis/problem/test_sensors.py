"""Channels that are treated like motor currents: one course, by its own name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from diagnosis.problem.sensors import as_currents, with_actuators
from diagnosis.result import Diagnosis
from diagnosis.workflow import diagnose
from recordings import Recording
from scenarios.errors import InputError
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import ALL_BUT_SEVEN

HERE = Path("satellite.parquet")
TIME_S = np.arange(0.0, 300.0, 0.2)


def satellite(slow_nT: float = 0.0) -> Recording:
    """At rest, two rods switched now and then."""
    rng = np.random.default_rng(4)
    rods = {name: np.repeat(rng.integers(0, 2, 30), 50) * 0.05 for name in ("rod_a_A_m2", "rod_b_A_m2")}
    moved = np.column_stack([*rods.values()]) @ np.array([[2e5, 0.0, 4e5], [1e5, 3e5, 0.0]])
    slow = slow_nT * np.sin(TIME_S / 3.0)[:, None] * [1.0, 0.0, 1.0]
    mag_nT = np.array([2e4, 1e4, -4e4]) + moved + slow + 100.0 * rng.normal(size=moved.shape)
    return Recording(time_s=TIME_S, mag_nT=mag_nT, channels=rods)


def found(recording: Recording) -> Diagnosis:
    return diagnose(recording, ModelSpec(), strength_nT=45_000.0, fitted_base=True, without=ALL_BUT_SEVEN)


def test_a_channel_and_the_current_that_it_became_are_one() -> None:
    given = satellite()
    assert as_currents(given) == {}
    both = with_actuators(given, ("rod_b_A_m2", "rod_a_A_m2"), HERE)
    assert as_currents(both) == {"rod_a_A_m2": "current_2_A", "rod_b_A_m2": "current_1_A"}


def test_what_was_given_as_an_actuator_is_told_by_its_own_name_and_not_asked_for_again() -> None:
    told = found(with_actuators(satellite(slow_nT=300.0), ("rod_a_A_m2", "rod_b_A_m2"), HERE))
    assert told.named[0].name == "motor_current"
    assert "of rod_a_A_m2, rod_b_A_m2" in told.sentence
    assert not {"current_1_A", "current_2_A"} & {one.channel for one in told.where}
    assert "--actuator" not in " ".join(told.advice)


def test_one_that_was_not_given_is_asked_for() -> None:
    told = found(with_actuators(satellite(), ("rod_a_A_m2",), HERE))
    assert "rod_b_A_m2" in told.sentence + " ".join(told.advice)


def test_a_channel_that_is_not_there_is_refused() -> None:
    with pytest.raises(InputError, match="rod_c"):
        with_actuators(satellite(), ("rod_c_A_m2",), HERE)
