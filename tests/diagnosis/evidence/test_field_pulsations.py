"""The period of a field that swings is found beside a ramp and a wander, and no wander swings."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from diagnosis.decision.choice import AcceptedEffect
from diagnosis.decision.selection import _refit_settings, select
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.field_pulsations import find_pulsations
from diagnosis.evidence.held_out import judge_candidate
from diagnosis.library.candidates import propose_candidates
from diagnosis.policy import STANDARD
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects import EFFECTS
from tests.diagnosis.synthetic import HZ, problem, recording

SWINGING = next(effect for effect in EFFECTS if effect.with_role("period"))
DRIVEN = next(effect for effect in EFFECTS if effect.with_role("motor") and not effect.search_role())
PERIOD = str(SWINGING.with_role("period"))
WALK_NT = 0.15
"""A step's standard deviation: in 600 s it goes 12 nT away, six times the noise of a sample."""


def _walk(seed: int, n: int) -> Array:
    return np.asarray(WALK_NT * np.random.default_rng(seed).normal(size=(n, 3)).cumsum(axis=0))


def _posed(course_enu_nT: Any = 0.0, walk: bool = False, n: int = 6000, **made: Any) -> LinearProblem:
    """A recording with a course (n, 3) of the earth's field, and a wander of the sensor's axes."""
    given = recording(n, **made)
    R_wb = problem(given).state.R_wb
    swing_nT = np.einsum("nji,nj->ni", R_wb, np.broadcast_to(course_enu_nT, (n, 3)))
    return problem(replace(given, mag_nT=given.mag_nT + swing_nT + (_walk(1, n) if walk else 0.0)))


def _wave(period_s: float, size_nT: float, n: int = 6000) -> Array:
    angle = 2 * np.pi * np.arange(n) / HZ / period_s
    return np.outer(np.sin(angle + 0.7) - np.sin(0.7), size_nT * np.array([0.6, -0.5, 0.6]))


def _period(posed: LinearProblem) -> float:
    (found,) = find_pulsations(Baseline.of(posed), propose_candidates(posed))
    return float(dict(found.candidate.nonlinear)[PERIOD])


@pytest.mark.parametrize("period_s", [41.0, 97.3, 280.0])
def test_the_period_is_found_between_the_lines_of_the_spectrum(period_s: float) -> None:
    assert _period(_posed(_wave(period_s, 2.0))) == pytest.approx(period_s, rel=0.01)


def test_a_ramp_is_no_period_and_hides_none() -> None:
    ramp = np.outer(np.linspace(0, 1, 6000) ** 2, [40.0, -60.0, 50.0])
    assert _period(_posed(ramp + _wave(70.0, 0.5))) == pytest.approx(70.0, rel=0.05)


def test_a_wander_that_is_larger_hides_none() -> None:
    assert _period(_posed(_wave(60.0, 2.0), walk=True)) == pytest.approx(60.0, rel=0.01)


def test_no_period_is_tried_of_which_the_run_holds_less_than_two() -> None:
    posed = _posed(_wave(450.0, 20.0))
    assert STANDARD.fastest_pulse_s <= _period(posed) <= 600.0 / STANDARD.least_pulse_cycles
    short = _posed(n=int(HZ * STANDARD.fastest_pulse_s * STANDARD.least_pulse_cycles))
    assert not find_pulsations(Baseline.of(short), propose_candidates(short))


def test_a_run_with_room_for_one_period_is_asked_for_that_one() -> None:
    n = int(1.02 * HZ * STANDARD.fastest_pulse_s * STANDARD.least_pulse_cycles)
    shortest_s = STANDARD.fastest_pulse_s
    assert _period(_posed(_wave(shortest_s, 20.0, n), n=n)) == pytest.approx(shortest_s, rel=0.1)


def test_the_effect_s_own_example_is_named_with_its_period() -> None:
    truth = SWINGING.example[PERIOD]
    posed = problem(recording(round(HZ * 2.5 * truth), hidden={SWINGING.name: SWINGING.example}))
    (found,) = select(posed).accepted
    assert (found.name, found.alternatives) == (SWINGING.name, ())
    assert dict(found.evidence.candidate.nonlinear)[PERIOD] == pytest.approx(truth, rel=0.01)


def test_a_wander_is_named_nothing() -> None:
    assert not select(_posed(walk=True)).accepted


def test_another_effect_beside_it_leaves_it_its_period() -> None:
    gain = {DRIVEN.linear[0]: [3.0, -2.0, 4.0]}
    posed = _posed(_wave(80.0, 4.0), hidden={DRIVEN.name: gain})
    baseline, members = Baseline.of(posed), propose_candidates(posed)
    (swinging,), driven = find_pulsations(baseline, members), judge_candidate(baseline, members[DRIVEN.name])
    assert driven is not None
    (after,) = _refit_settings(AcceptedEffect(driven, ()), [AcceptedEffect(swinging, ())], members, baseline)
    assert after.evidence.candidate == swinging.candidate
