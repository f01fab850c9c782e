"""Accepted effects beside the next: settled anew, and no second name for a gain that grows or fades."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.decision.choice import AcceptedEffect, Selection, residual_tests
from diagnosis.decision.selection import _grows_with_time, _refit_settings, select
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import judge_candidate, judge_settings
from diagnosis.library.candidates import Candidate, propose_candidates
from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.effects.nonlinearity import ROUNDED
from tests.diagnosis.synthetic import problem, recording

DRIFT = next(effect for effect in EFFECTS if any(p.unit == "nT/h" for p in effect.parameters()))
LOOP = next(
    effect
    for effect in EFFECTS
    if len(effect.forms) and effect.traits.correlates_noise is False and "gain" in effect.linear
)
DRIVEN = next(effect for effect in EFFECTS if effect.with_role("motor") and not effect.search_role())
TABLES = {DRIVEN.name: {DRIVEN.linear[0]: [3.0, -2.0, 4.0]}, LOOP.name: {"gain": [0.01] * 3, "threshold_nT": 1000.0}}
SLOW = {DRIFT.name: {DRIFT.linear[0]: [200.0, -300.0, 150.0]}}


def _best(baseline: Baseline, effect: type[Effect]) -> AcceptedEffect:
    found = judge_candidate(baseline, propose_candidates(baseline.problem)[effect.name])
    assert found is not None
    return AcceptedEffect(found, ())


def _so_far(end: Baseline, *accepted: AcceptedEffect) -> Selection:
    """A selection with effects in its last baseline."""
    tests = residual_tests(end, [effect.name for effect in accepted])
    return Selection(accepted, end, end, tests, tests, (), frozenset())


def test_an_effect_is_settled_anew_beside_what_was_hidden() -> None:
    """Beside a drift the best loop is another one."""
    given = recording(hidden={LOOP.name: {"gain": [0.02] * 3, "threshold_nT": 1700.0}})
    slow = np.outer(np.linspace(-300.0, 300.0, len(given)), [1.0, -1.0, 0.5])
    start = Baseline.of(problem(replace(given, mag_nT=given.mag_nT + slow)))
    members = propose_candidates(start.problem)
    worst = judge_settings(start, members[LOOP.name][:1])
    assert worst is not None
    drift = _best(start, DRIFT)
    (settled,) = _refit_settings(drift, [AcceptedEffect(worst, ())], members, start)
    assert (
        settled.evidence.candidate
        == judge_candidate(start.with_columns(drift.columns(start.problem)), members[LOOP.name]).candidate
    )  # type: ignore[union-attr]
    assert settled.evidence.nats == worst.nats
    assert settled.evidence.candidate != worst.candidate


@pytest.mark.slow
def test_a_current_whose_gain_fades_is_no_drift_beside_a_current() -> None:
    """``g (1 - t / 2 T) I`` is not ``g I`` and a drift, though a drift leaves it clean; a real one has its name."""
    quiet = recording(2000)
    assert quiet.current_A is not None
    current_A, fade = quiet.current_A[:, :1], np.linspace(1.0, 0.5, 2000)[:, None]
    fading = replace(quiet, current_A=current_A, mag_nT=quiet.mag_nT + fade * current_A * np.array([2.0, -1.0, 1.5]))
    assert [one.name for one in select(problem(fading)).accepted] == [DRIVEN.name]
    drifting = problem(hidden={DRIVEN.name: {DRIVEN.linear[0]: [4.0, -2.0, 3.0]}} | SLOW)
    assert {one.name for one in select(drifting).accepted} == {DRIVEN.name, DRIFT.name}


def test_a_loop_beside_a_current_is_no_growth_of_it() -> None:
    """Its state at the start is foretold wildly where the start is held out; by all data it tells."""
    core = {"rounded_gain": (0.004,) * 3, "rounded_threshold_nT": 3000.0, "rounded_start_nT": (-60.0, 40.0, 50.0)}
    posed = problem(hidden=TABLES | {LOOP.name: core})
    current = judge_settings(Baseline.of(posed), [Candidate(DRIVEN)])
    assert current is not None
    rounded = Candidate(LOOP, (("rounded_threshold_nT", 3000.0),), forms=(ROUNDED,))
    baseline = Baseline.of(posed, [Candidate(DRIVEN).columns(posed)])
    columns = rounded.columns(posed)
    assert baseline.evidence_of(columns) < 0 < baseline.evidence_on_all(columns)
    loop = AcceptedEffect(replace(current, candidate=rounded), ())
    assert not _grows_with_time(loop, _so_far(baseline, AcceptedEffect(current, ())))


def test_a_drift_beside_a_current_that_fades_is_no_growth_of_it() -> None:
    """The growth explains more than the drift, and leaves the drift what it explains."""
    made = recording(2000, hidden={DRIFT.name: {DRIFT.linear[0]: [60.0, -90.0, 45.0]}})
    assert made.current_A is not None
    current_A, fade = made.current_A[:, :1] - 2.0, np.linspace(2.0, -2.0, 2000)[:, None]
    fading = replace(made, current_A=current_A, mag_nT=made.mag_nT + fade * current_A * np.array([4.0, -2.0, 3.0]))
    posed = problem(fading)
    current, drift = Candidate(DRIVEN), Candidate(DRIFT)
    baseline = Baseline.of(posed, [current.columns(posed)])
    judged = [judge_settings(baseline, [drift]), judge_settings(Baseline.of(posed), [current])]
    slow, driven = (AcceptedEffect(one, ()) for one in judged if one is not None)
    assert 0 < baseline.evidence_on_all(drift.columns(posed)) < 1000
    assert not _grows_with_time(slow, _so_far(baseline, driven))
