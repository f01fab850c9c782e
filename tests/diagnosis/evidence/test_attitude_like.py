"""An attitude that is turned, a little more at the end than at the beginning, beside fields of their own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.decision.selection import select
from diagnosis.evidence import attitude_like as turning
from diagnosis.evidence.attitude_like import TURNS, attitude_explains_as_much
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import judge_candidate
from diagnosis.library.candidates import Candidate, propose_candidates
from diagnosis.problem.linear import LinearProblem
from recordings import Recording
from tests.diagnosis.synthetic import FIELD_ENU_NT, HZ, problem, recording

G = np.array([[0.4, -0.2, 0.1], [-0.2, 0.3, 0.5], [0.1, 0.5, -0.7]])


def _along_a_line(n: int) -> Recording:
    """A track with a sway: on a line a gradient from afar is a constant that grows with time."""
    t = np.arange(n) / HZ
    way = np.column_stack([0.3 * t, 0.2 * t, -0.05 * t]) + 8 * np.sin(0.12 * t)[:, None] * [1.0, -1.0, 0.5]
    return replace(recording(n), pos_enu_m=way)


def _with(given: Recording, change_enu_nT: np.ndarray) -> LinearProblem:  # type: ignore[type-arg]
    added = np.einsum("nji,nj->ni", problem(given).state.R_wb, change_enu_nT)
    return problem(replace(given, mag_nT=given.mag_nT + added))


def _turned(given: Recording) -> LinearProblem:
    growing = 1 + 0.05 * np.linspace(0, 1, len(given))
    return _with(given, growing[:, None] * np.cross([3e-3, -2e-3, 1e-3], FIELD_ENU_NT))


def _gradient(posed: LinearProblem) -> tuple[Baseline, Baseline, Candidate]:
    """The ground of a problem, with the gradient that fits it best, and that one."""
    name = next(name for name, several in propose_candidates(posed).items() if several[0].effect.with_role("origin"))
    baseline = Baseline.of(posed)
    one = judge_candidate(baseline, propose_candidates(posed)[name])
    assert one is not None
    return baseline, baseline.with_columns(one.candidate.columns(posed)), one.candidate


def test_what_a_turn_that_grows_explains_as_well_is_not_told_from_it() -> None:
    assert attitude_explains_as_much(*_gradient(_turned(_along_a_line(3000))))


@pytest.mark.parametrize("shows", [True, False])
def test_a_gradient_is_told_along_the_field_or_by_the_place(shows: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    given = _along_a_line(3000)
    if not shows:  # as on a hover, where the base takes up what lies along the field
        monkeypatch.setattr(turning, "explains_along_field", lambda before, after, tried: False)
    assert given.pos_enu_m is not None
    assert not attitude_explains_as_much(*_gradient(_with(given, (given.pos_enu_m - [300.0, 0.0, 0.0]) @ G)))


def test_none_is_asked_of_what_is_no_field_of_its_own() -> None:
    posed = _turned(_along_a_line(3000))
    baseline = Baseline.of(posed)
    for name in TURNS:
        (one,) = propose_candidates(posed)[name]
        assert not attitude_explains_as_much(baseline, baseline.with_columns(one.columns(posed)), one)


def test_a_turned_attitude_is_no_gradient_from_afar() -> None:
    first = select(_turned(_along_a_line(3000))).accepted[0]
    assert TURNS & {first.name, *first.alternatives}


def test_a_constant_error_that_grows_a_little_on_the_way_is_no_gradient_from_afar() -> None:
    given = _along_a_line(3000)
    assert given.pos_enu_m is not None
    way = given.pos_enu_m @ [0.6, 0.6, 0.5]
    growing = 1 + 0.02 * (way - way.mean()) / np.ptp(way)
    first = select(_with(given, growing[:, None] * [30.0, -20.0, 13.0])).accepted[0]
    assert first.name in TURNS
