"""A current has one gain all along, to a tenth too, and in a part of the run; one that turns round has none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.evidence.constancy import coefficients_change
from diagnosis.evidence.held_out import judge_candidate
from diagnosis.library.candidates import propose_candidates
from scenarios.arrays import Array
from sim.effects import EFFECTS
from tests.diagnosis.synthetic import problem, recording

DRIVEN = next(effect for effect in EFFECTS if effect.with_role("motor") and not effect.search_role())
N = 1500
GAIN_NT_A = np.array([3.0, -2.0, 1.0])
TIME = np.linspace(0, 1, N)


@pytest.mark.parametrize(
    ("gain", "differs"),
    [
        (np.ones(N), False),
        (1 + 0.1 * np.sin(2 * np.pi * TIME), False),
        (np.where(TIME < 0.6, 1.0, -1.0), True),
        (TIME < 0.5, True),
    ],
)
def test_a_gain_that_changes_is_none(gain: Array, differs: bool) -> None:
    given = recording(N)
    assert given.current_A is not None
    added_nT = (gain * given.current_A[:, 0])[:, None] * GAIN_NT_A
    posed = problem(replace(given, mag_nT=given.mag_nT + added_nT))
    evidence = judge_candidate(Baseline.of(posed), propose_candidates(posed)[DRIVEN.name])
    assert evidence is not None
    coloured_baseline = ColouredBaseline.of(posed, ())
    one = coloured_baseline.fit_candidate(evidence, coloured_baseline.rows.bin(evidence.candidate.columns(posed)))
    assert coefficients_change(one, coloured_baseline, posed.policy.other_size) is differs
