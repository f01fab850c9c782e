"""What a smooth course of time follows better is no drift; a drift, and what is fast beside a slow course, stand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.evidence.held_out import judge_candidate
from diagnosis.evidence.smooth_course import (
    field_course_explains_more,
    place_course_explains_more,
    time_course_explains_more,
)
from diagnosis.library.candidates import propose_candidates
from scenarios.arrays import Array
from sim.effects import EFFECTS
from tests.diagnosis.synthetic import problem, recording

DRIVEN = next(effect for effect in EFFECTS if effect.with_role("motor") and not effect.search_role())
DRIFT = next(effect for effect in EFFECTS if any(p.unit == "nT/h" for p in effect.parameters()))
SIZES_NT = np.array([5.0, -4.0, 3.0])


def _does_better(name: str, slow: Array, hidden: dict[str, Any] | None = None, *, earth: bool = False) -> bool:
    """Of an effect in a recording with a slow course (n, 3) of the axes, or the field, whether any does better."""
    given = recording(len(slow), hidden=hidden)
    R_bw = problem(given).state.R_wb.transpose(0, 2, 1) if earth else np.eye(3)
    posed = problem(replace(given, mag_nT=given.mag_nT + (R_bw @ (slow * SIZES_NT)[:, :, None])[:, :, 0]))
    evidence = judge_candidate(Baseline.of(posed), propose_candidates(posed)[name])
    assert evidence is not None
    coloured_baseline = ColouredBaseline.of(posed, ())
    standing = coloured_baseline.fit_candidate(evidence, coloured_baseline.rows.bin(evidence.candidate.columns(posed)))
    assert standing.gain > 0
    asked = field_course_explains_more if earth else time_course_explains_more
    return asked(standing, coloured_baseline, posed)


X = np.linspace(-1, 1, 1500)[:, None]
EACH_ITS_OWN = X + X**2 * np.array([1.0, -1.0, 0.5])


@pytest.mark.parametrize(
    ("course", "better"), [(X * np.ones(3), False), (X + 0.7 * X**2 * np.ones(3), False), (EACH_ITS_OWN, True)]
)
def test_a_drift_of_any_one_form_stands_and_axes_that_go_their_own_ways_are_none(course: Array, better: bool) -> None:
    assert _does_better(DRIFT.name, course) is better


def test_what_is_fast_beside_a_slow_course_stands() -> None:
    """The course gains more, but does nothing of what the current does."""
    assert not _does_better(DRIVEN.name, 3 * EACH_ITS_OWN, {DRIVEN.name: {DRIVEN.linear[0]: [0.6, -0.3, 0.4]}})


STRONG = {DRIVEN.name: {DRIVEN.linear[0]: [1.2, -0.6, 0.8]}}


@pytest.mark.parametrize(
    ("name", "size", "hidden", "better"),
    [("temperature_scale", 3.0, None, True), ("diurnal_drift", 3.0, None, False), (DRIVEN.name, 0.3, STRONG, False)],
)
def test_a_field_that_changes_is_no_effect_that_follows_it_for_a_part(
    name: str, size: float, hidden: dict[str, Any] | None, better: bool
) -> None:
    """A field of its own is, and what is fast beside it stands."""
    assert _does_better(name, size * EACH_ITS_OWN, hidden, earth=True) is better


@pytest.mark.parametrize(
    ("name", "hidden", "better"),
    [
        (
            "diurnal_drift",
            {"field_gradient": {"gradient_nT_m": [[0.3, 0.1, 0.2], [0.1, -0.5, 0.1], [0.2, 0.1, 0.2]]}},
            True,
        ),
        ("diurnal_drift", {"diurnal_drift": {"amplitude_enu_nT": [8.0, -5.0, 6.0], "period_s": 400.0}}, False),
        (
            "regional_field",
            {"field_gradient": {"gradient_nT_m": [[0.3, 0.1, 0.2], [0.1, -0.5, 0.1], [0.2, 0.1, 0.2]]}},
            False,
        ),
        ("field_gradient", {"diurnal_drift": {"amplitude_enu_nT": [8.0, -5.0, 6.0], "period_s": 400.0}}, False),
    ],
)
def test_a_field_of_places_met_one_after_the_other_is_no_change_in_time(
    name: str, hidden: dict[str, Any], better: bool
) -> None:
    given = recording(hidden=hidden)
    for posed, asked in ((problem(given), better), (problem(replace(given, pos_enu_m=None)), False)):
        if name not in propose_candidates(posed):
            continue
        evidence = judge_candidate(Baseline.of(posed), propose_candidates(posed)[name])
        assert evidence is not None
        coloured_baseline = ColouredBaseline.of(posed, ())
        standing = coloured_baseline.fit_candidate(
            evidence, coloured_baseline.rows.bin(evidence.candidate.columns(posed))
        )
        assert place_course_explains_more(standing, coloured_baseline, posed) is asked
