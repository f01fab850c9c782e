"""An effect that comes and goes with a channel is at its most in a part of the run, and has no window."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.decision.coloured_choice import CandidateTest
from diagnosis.decision.selection import select
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import judge_settings
from diagnosis.evidence.localise import TIME
from diagnosis.evidence.smooth_windows import channels_on_within, equivalent_course
from diagnosis.evidence.windowed_candidates import recurs_outside_window
from diagnosis.library.candidates import Candidate, iron_candidates
from diagnosis.policy import STANDARD, Policy
from diagnosis.problem.linear import LinearProblem
from recordings.channels import TEMPERATURE
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.effects.parameters import ACTIVE_WINDOW
from tests.diagnosis.synthetic import problem, recording

WARM = next(effect for effect in EFFECTS if any(p.unit == "1/K" for p in effect.parameters()))
IN_PART = {ACTIVE_WINDOW.name: (90.0, 210.0)}


def _growing(course: Array, size: float = 2e-3, policy: Policy = STANDARD) -> LinearProblem:
    """A sensitivity, of two thousandths where nothing else is said, of a course (n,) that is 0 to 1."""
    given = recording(len(course))
    given.mag_nT[:] *= 1 + size * course[:, None] * [1.0, -0.6, 0.8]
    return problem(given, policy=policy)


def _pulses(*pieces: tuple[float, float]) -> Array:
    """A course (n,) that is 1 in pieces of the run."""
    t = recording(3000).time_s
    return np.any([(t >= a) & (t < b) for a, b in pieces], axis=0).astype(float)


def _window() -> Candidate:
    iron = (several[0] for several in iron_candidates().values())
    return next(one for one in iron if not one.effect.traits.constant).at(IN_PART)


@pytest.mark.parametrize(("name", "told"), [("switch", ""), ("bend", TIME), ("warm", TEMPERATURE)])
def test_a_window_is_one_where_no_course_does_as_well(name: str, told: str) -> None:
    t, heat = recording(3000).time_s, recording(3000).temperature_degC
    assert heat is not None
    x = t / t[-1]
    courses = {"switch": (t >= 90) & (t < 210), "bend": x * (1 - x) * 4, "warm": (heat - 15) / 3}
    baseline = Baseline.of(_growing(courses[name].astype(float)))
    assert equivalent_course(baseline, _window()) == told


@pytest.mark.parametrize(("power", "told"), [(0.0, ""), (0.5, "payload")])
def test_a_channel_that_is_on_in_the_window_does_better_or_is_the_window(power: float, told: str) -> None:
    """Of a payload whose level within it counts too the window is only the middle of the course."""
    t = recording(3000).time_s
    course = np.clip(1 - ((t - 150) / 60) ** 2, 0, None) ** power * ((t >= 90) & (t < 210))
    posed = _growing(course)
    driven = replace(posed, state=replace(posed.state, channels={"payload": course}))
    assert channels_on_within(driven, IN_PART[ACTIVE_WINDOW.name]) == ("payload",)
    assert equivalent_course(Baseline.of(driven), _window()) == told


@pytest.mark.parametrize(("pieces", "again"), [([(90, 210)], False), ([(80, 90), (210, 220)], True)])
def test_what_comes_in_pieces_has_no_window(pieces: list[tuple[int, int]], again: bool) -> None:
    """Between two pulses an offset of the other sign fits best, and about both as much is left."""
    baseline = Baseline.of(_growing(_pulses(*pieces)))
    between = _window().at({ACTIVE_WINDOW.name: (min(b for _, b in pieces), 210.0) if again else (90.0, 210.0)})
    with_it = baseline.with_columns(between.columns(baseline.problem))
    assert recurs_outside_window(baseline, with_it, between) == again
    assert not recurs_outside_window(baseline, with_it, Candidate(WARM))


def test_what_is_left_elsewhere_is_another_window() -> None:
    baseline = Baseline.of(_growing(_pulses((40, 90), (210, 260))))
    first = _window().at({ACTIVE_WINDOW.name: (40.0, 90.0)})
    assert not recurs_outside_window(baseline, baseline.with_columns(first.columns(baseline.problem)), first)


def test_a_course_that_the_data_do_not_tell_from_a_window_is_held_for_one() -> None:
    weak = [_growing(_pulses((90, 210)), 5e-5, policy) for policy in (STANDARD, replace(STANDARD, alpha=1e-300))]
    assert [equivalent_course(Baseline.of(one), _window()) == "" for one in weak] == [True, False]


@pytest.mark.parametrize(
    ("pieces", "span", "told"),
    [([(90, 210)], (90, 210), ""), ([(60, 90), (210, 240)], (90, 210), "also present outside its window")],
)
def test_a_hearing_says_why_it_is_no_window(
    pieces: list[tuple[float, float]], span: tuple[float, float], told: str
) -> None:
    posed = _growing(_pulses(*pieces))
    baseline = Baseline.of(replace(posed, state=replace(posed.state, channels={})))
    one = judge_settings(baseline, [_window().at({ACTIVE_WINDOW.name: span})])
    assert one is not None
    with_it = baseline.with_columns(one.candidate.columns(baseline.problem))
    hearing = CandidateTest(baseline, None, baseline, lambda *_: True)  # type: ignore[arg-type]
    assert hearing._refusal_by_course(one, with_it) == told


def test_what_acts_all_along_is_not_asked() -> None:
    baseline = Baseline.of(_growing(np.zeros(3000)))
    assert equivalent_course(baseline, Candidate(WARM)) == ""


def test_a_sensitivity_that_follows_the_temperature_is_no_other_for_a_time() -> None:
    """With the effect left out of the library, nothing gets a window, neither as the best nor as its look-alike."""
    heat = recording(3000).temperature_degC
    assert heat is not None
    found = select(_growing((heat - 15) / 3), without=frozenset({WARM.name})).accepted
    assert all(one.evidence.candidate.window is None for one in found)
