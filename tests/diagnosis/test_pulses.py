"""What comes and goes twice is one cause, told by its own times."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.decision.choice import AcceptedEffect, Selection, baseline_with, residual_tests
from diagnosis.decision.selection import choose_windows_again
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import judge_settings
from diagnosis.library.candidates import Candidate
from diagnosis.workflow import diagnose
from sim.effects.iron import HardIron, SoftIron
from sim.effects.parameters import ACTIVE_WINDOW
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import COSTLY, FIELD_ENU_NT, problem, recording

MODEL = ModelSpec.model_validate(
    {"effects": {"white_noise": {"std_nT": [2.0] * 3}}, "field": {"enu_nT": FIELD_ENU_NT.tolist()}}
)
PULSES_S = ((80.0, 90.0), (210.0, 220.0))


def test_two_short_pulses_are_one_magnet_at_their_own_times() -> None:
    """Beside the second pulse a current or a changed scale fits the first better than the magnet does."""
    given = recording(3000, seed=2)
    on = np.logical_or.reduce([(given.time_s >= a) & (given.time_s < b) for a, b in PULSES_S])
    pulsed = replace(given, mag_nT=given.mag_nT + np.outer(on, [12.0, -8.0, 6.0]))
    found = diagnose(pulsed, MODEL, without=COSTLY)
    (cause,) = found.named
    assert found.verdict.explained
    assert cause.name == HardIron.name
    windows = sorted(effect.active_s for effect in cause.effects if effect.active_s is not None)
    assert [end for window in windows for end in window] == pytest.approx(np.ravel(PULSES_S), abs=0.3)


def test_what_later_effects_explain_is_left_out() -> None:
    """Beside the second pulse a changed scale fits the first; beside the magnet's own two times it fits nothing."""
    pulses = [{"offset_nT": [12.0, -8.0, 6.0], "active_s": list(window_s)} for window_s in PULSES_S]
    start = Baseline.of(problem(hidden={HardIron.name: pulses}))
    parts = ((SoftIron, PULSES_S[0]), (HardIron, PULSES_S[0]), (HardIron, PULSES_S[1]))
    found = (judge_settings(start, [Candidate(*each).at({ACTIVE_WINDOW.name: w})]) for *each, w in parts)
    accepted = [
        AcceptedEffect(one, (), form_of=None if k == 0 else SoftIron.name) for k, one in enumerate(found) if one
    ]
    end, before = baseline_with(accepted, start), residual_tests(start, ())
    after = residual_tests(end, [one.name for one in accepted])
    again = choose_windows_again(Selection(tuple(accepted), start, end, before, after, (), frozenset()))
    assert len(accepted) == 3
    assert again.names == [HardIron.name] * 2
    assert again.clean
    assert {one.form_of for one in again.accepted} == {None}
