"""A sensitivity that follows a channel, found among channels, and held against names that explain less."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.decision.verdict_rules import doubts_of, iron_follows_a_channel, unnamed_channels, verdict_of
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.localise import ChannelShare, find_followed_channel
from diagnosis.problem.linear import LinearProblem
from diagnosis.verdict import Verdict
from recordings.channels import TEMPERATURE, current_name
from sim.effects import EFFECTS
from sim.effects.kernels import first_order_lag
from tests.diagnosis.decision.answers import FOUND, case_of
from tests.diagnosis.synthetic import HZ, problem, recording, without_attitude


@pytest.fixture(scope="module")
def warm() -> LinearProblem:
    """Axes whose sensitivity follows the temperature, late."""
    given = recording(3000)
    assert given.temperature_degC is not None
    late = np.interp(given.time_s - 4.0, given.time_s, given.temperature_degC) - 15
    return problem(replace(given, mag_nT=given.mag_nT * (1 + 3e-4 * late[:, None] * [1.0, -0.6, 0.8])))


def test_of_several_channels_the_one_is_found_that_the_iron_follows(warm: LinearProblem) -> None:
    found = find_followed_channel(Baseline.of(warm), (TEMPERATURE, current_name(1), current_name(2)))
    assert found is not None
    assert found.channel == TEMPERATURE
    assert found.share > 0.9
    other = find_followed_channel(Baseline.of(warm), (current_name(1),))
    assert other is not None
    assert other.share < 0.3
    assert find_followed_channel(Baseline.of(warm), ()) is None


@pytest.mark.parametrize("way", ["late", "squared"])
def test_a_channel_is_followed_late_and_with_its_powers(way: str) -> None:
    given = recording(3000)
    assert given.current_A is not None
    swing = given.current_A[:, :1] - 2
    course = first_order_lag(swing, 3.0, 1 / HZ, {}) if way == "late" else swing**2
    posed = problem(replace(given, mag_nT=given.mag_nT * (1 + 1e-3 * course * [1.0, -0.6, 0.8])))
    found = find_followed_channel(Baseline.of(posed), (current_name(1),))
    assert found is not None
    assert found.share > 0.7


def test_the_strength_alone_has_no_axes_of_which_one_follows() -> None:
    posed = problem(without_attitude(recording(500)))
    assert find_followed_channel(Baseline.of(posed), (TEMPERATURE,)) is None


@pytest.mark.parametrize(("explained", "doubted"), [(0.4, True), (1.0, False)])
def test_names_that_explain_far_less_are_taken_back(warm: LinearProblem, explained: float, doubted: bool) -> None:
    where = (ChannelShare("time_s", "body", 0.5), ChannelShare(TEMPERATURE, "body", 0.3))
    case = case_of(FOUND, clean=False, explained=explained, problem=warm, where=where)
    assert verdict_of(case) is Verdict.PARTIAL
    assert TEMPERATURE in unnamed_channels(case)
    reason = next(iron_follows_a_channel(case), None)
    assert (reason is not None and TEMPERATURE in reason) == doubted
    assert bool(doubts_of(case, Verdict.PARTIAL)) == doubted
    elsewhere = replace(case, where=where[:1])
    assert not list(iron_follows_a_channel(elsewhere))


@pytest.mark.parametrize("channel", [TEMPERATURE, current_name(1)])
def test_what_a_name_has_for_its_cause_is_not_asked(warm: LinearProblem, channel: str) -> None:
    """To an effect of the currents all motors are one."""
    motors = {current_name(motor) for motor in warm.state.motors}
    assert len(motors) > 1
    caused = next(cls(**cls.example) for cls in EFFECTS if channel in cls(**cls.example).required_inputs)
    case = case_of(replace(FOUND, effect=caused), problem=warm)
    listed = case_of(replace(FOUND, alternatives=(caused.name,)), problem=warm)
    known = motors if channel in motors else {channel}
    assert set(warm.state.channels) - unnamed_channels(case) == known
    assert set(warm.state.channels) - unnamed_channels(listed) >= known
    assert set(warm.state.channels) == unnamed_channels(replace(case, named=()))
