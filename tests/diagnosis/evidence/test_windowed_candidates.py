"""Candidates in a part of the run: which windows are worth asking, which are a jump, and what comes again."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import Evidence
from diagnosis.evidence.windowed_candidates import Span, _in, _is_worth, rank_windowed
from diagnosis.library.candidates import Candidate, propose_candidates
from diagnosis.policy import STANDARD, Policy
from scenarios.arrays import Array
from sim.effects.currents import EddyCurrent, MotorCurrent
from sim.effects.iron import HardIron
from sim.effects.nonlinearity import Hysteresis
from tests.diagnosis.synthetic import problem

N = 2000
T_S = np.arange(N) / 10.0
TO = np.array([3.0, -1.5, 2.0])
MOTOR, EDDY = Candidate(MotorCurrent), Candidate(EddyCurrent)


def _ground(added: Array, policy: Policy = STANDARD) -> Baseline:
    posed = problem(n=N, policy=policy)
    return Baseline.of(replace(posed, target=posed.target + added))


def _during(begin_s: float, end_s: float) -> Array:
    return ((begin_s <= T_S) & (end_s > T_S)).astype(float)[:, None]


def _found(baseline: Baseline, members: dict[str, list[Candidate]]) -> dict[str, Evidence]:
    return {one.name: one for one in rank_windowed(baseline, [], members)}


MOVED = MOTOR.columns(problem(n=N)) @ TO


@pytest.mark.parametrize(
    ("gain", "whole", "worth"), [(26.0, 0.0, True), (24.0, 0.0, False), (100.0, 70.0, True), (100.0, 80.0, False)]
)
def test_a_window_is_worth_asking_beyond_a_colour_and_much_more_than_the_whole_run(
    gain: float, whole: float, worth: bool
) -> None:
    assert _is_worth(Span(0.0, 9.0, gain, whole), STANDARD) is worth


def test_a_window_pays_for_all_pairs_of_ends_that_are_compared() -> None:
    assert _in(replace(MOTOR, tried=5), Span(1.0, 9.0, 0.0, 0.0), STANDARD).tried == 5 * 80 * 81 // 2


@pytest.mark.parametrize("most", [1, 2])
def test_so_many_windows_are_asked_the_strongest_first(most: int) -> None:
    baseline = _ground(MOVED * _during(60, 90), replace(STANDARD, tried_coloured=most))
    found = rank_windowed(baseline, [], {MOTOR.name: [MOTOR]})
    assert len(found) == most
    assert found[0].name == MOTOR.name


def _added(one: Candidate) -> Array:
    """What an effect adds, of three sigma in the mean."""
    columns = one.columns(problem(n=N))
    added = columns @ np.linspace(1, 0.5, columns.shape[2])
    return np.asarray(3 * added / np.sqrt((added**2).mean()))


@pytest.mark.parametrize(
    ("effect", "name", "value"), [(EddyCurrent, "time_constant_s", 3.0), (Hysteresis, "threshold_nT", 3e3)]
)
def test_a_setting_is_chosen_in_the_window_and_the_window_by_it(effect: Any, name: str, value: float) -> None:
    """The first that is listed shows a part of it, in a window of its own."""
    baseline = _ground(_added(Candidate(effect, ((name, value),))) * _during(40, 100))
    one = _found(baseline, {effect.name: propose_candidates(baseline.problem)[effect.name]})[effect.name]
    assert dict(one.candidate.nonlinear)[name] == value
    assert one.candidate.window == pytest.approx((40.0, 100.0), abs=1.0)


@pytest.mark.parametrize(
    ("begin_s", "end_s", "names"), [(80.0, 1e3, set()), (60.0, 120.0, {HardIron.name, MOTOR.name})]
)
def test_a_constant_from_a_moment_on_is_a_jump_whatever_explains_some_of_it(
    begin_s: float, end_s: float, names: set[str]
) -> None:
    """A current that never rests has one too."""
    found = _found(_ground(TO * _during(begin_s, end_s)), {MOTOR.name: [MOTOR]})
    assert found.keys() & {HardIron.name, MOTOR.name} == names


def test_what_is_no_constant_may_act_from_a_moment_on() -> None:
    found = _found(_ground(_added(EDDY) * _during(80, 1e3)), {EDDY.name: [EDDY]})
    assert found[EDDY.name].candidate.window == pytest.approx((80.0, 200.0), abs=1.0)
