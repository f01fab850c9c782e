"""Lobes of a heading that turns evenly are not told a tone, and a tone between them is."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from diagnosis.decision.selection import select
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.heading_harmonics import follows_earth_frame, follows_heading
from diagnosis.evidence.held_out import Evidence, judge_candidate
from diagnosis.library.candidates import propose_candidates
from diagnosis.problem.linear import LinearProblem
from sim.effects import EFFECTS
from tests.diagnosis.synthetic import problem, recording, without_attitude

TONE = next(effect for effect in EFFECTS if effect.with_role("frequency") and effect.with_role("motor"))
LOBES = 6
ALONG = np.array([3.0, -2.0, 4.0])


def _posed(course: Any) -> LinearProblem:
    """A course of the heading and the time (rad, s), times the currents, of a vehicle that turns nearly evenly."""
    given = recording()
    heading = _heading(problem(given))
    current = given.current_A.sum(axis=1)
    return problem(replace(given, mag_nT=given.mag_nT + np.outer(current * course(heading, given.time_s), ALONG)))


def _heading(posed: LinearProblem) -> Any:
    return np.unwrap(np.arctan2(posed.state.R_wb[:, 1, 0], posed.state.R_wb[:, 0, 0]))


def _tone(posed: LinearProblem) -> tuple[Baseline, Evidence]:
    baseline = Baseline.of(posed)
    found = judge_candidate(baseline, propose_candidates(posed)[TONE.name])
    assert found is not None
    return baseline, found


def test_what_follows_the_heading_is_no_tone() -> None:
    posed = _posed(lambda heading, time_s: np.sin(LOBES * heading + 0.4))
    assert follows_heading(*_tone(posed))
    assert not select(posed).accepted


@pytest.mark.parametrize("hz", [0.108, 0.31, 1.7])
def test_a_tone_that_does_not_keep_step_with_the_heading_is_one(hz: float) -> None:
    posed = _posed(lambda heading, time_s: np.sin(2 * np.pi * hz * time_s))
    assert not follows_heading(*_tone(posed))


@pytest.mark.parametrize("earth", [True, False])
def test_a_swell_is_no_motors_tone(earth: bool) -> None:
    """A swing of 8 s along the earth's axes, beside a current that hardly changes; or one of that current."""
    given = replace(recording(), current_A=2 + 0.05 * recording().current_A)
    R, current = problem(given).state.R_wb, given.current_A.sum(axis=1)
    wave = np.sin(2 * np.pi * given.time_s / 8)[:, None]
    added = np.einsum("nji,nj->ni", R, 4 * wave * ALONG) if earth else wave * current[:, None] * ALONG
    assert follows_earth_frame(*_tone(problem(replace(given, mag_nT=given.mag_nT + added)))) is earth


def test_only_a_tone_is_asked_and_only_with_attitude() -> None:
    baseline = Baseline.of(problem())
    for members in propose_candidates(baseline.problem).values():
        found = judge_candidate(baseline, members)
        assert found is None or not follows_heading(baseline, found)
    strength = Baseline.of(problem(without_attitude(recording())))
    tone = judge_candidate(strength, propose_candidates(strength.problem)[TONE.name])
    assert tone is None or not follows_heading(strength, tone)
