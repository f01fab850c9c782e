"""Which candidate is accepted, when another is only its form, and what is said of what is left."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfilt, sosfilt_zi

from diagnosis.decision.choice import (
    AcceptedEffect,
    Selection,
    _select_in_family,
    accept_best,
    residual_tests,
)
from diagnosis.decision.selection import _is_form_of_accepted, _refit_settings, _with_look_alike, select
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import Evidence, judge_settings
from diagnosis.evidence.residual_tests import ResidualTests
from diagnosis.library.candidates import Candidate, iron_candidates
from diagnosis.policy import STANDARD
from sim.effects import BY_NAME, EFFECTS
from sim.effects.base import Effect
from sim.effects.nonlinearity import Hysteresis
from sim.effects.offsets import OffsetJump
from sim.effects.parameters import ACTIVE_WINDOW
from tests.diagnosis.synthetic import COSTLY, problem, recording

FIRST, SECOND, THIRD = EFFECTS[:3]
CLEAN = ResidualTests(())
KIN = (("bandwidth", 0.0, 0.001), ("latency", 1.0, 0.1))


def _evidence(effect: type[Effect], gain: float, width: int = 3) -> Evidence:
    c, covariance = np.zeros(width), np.zeros((width, width))
    return Evidence(Candidate(effect), gain, 1.0, 1.0, 1.0, gain, c, covariance, 0.0, 0)


def _accepted(effect: type[Effect], strength: float) -> AcceptedEffect:
    return AcceptedEffect(replace(_evidence(effect, 100.0), strength=strength), ())


def _so_far(*accepted: AcceptedEffect) -> Selection:
    start = Baseline.of(problem(n=300))
    return Selection(accepted, start, start, CLEAN, CLEAN, (), frozenset())


def test_nothing_is_accepted_on_too_little_evidence() -> None:
    least = STANDARD.accepted(len(EFFECTS))
    assert accept_best((), STANDARD) is None
    assert accept_best((_evidence(FIRST, 0.99 * least),), STANDARD) is None
    assert accept_best((_evidence(FIRST, 1.01 * least),), STANDARD) is not None


def test_what_has_too_little_evidence_of_its_own_is_no_look_alike() -> None:
    gain = 1.01 * STANDARD.accepted(len(EFFECTS))
    for behind, alike in ((0.5, (SECOND.name,)), (0.98, ())):
        other = _evidence(SECOND, gain - behind * STANDARD.apart, 9)
        chosen = accept_best((_evidence(FIRST, gain), other), STANDARD)
        assert chosen is not None
        assert chosen.alternatives == alike


def test_of_one_kin_that_nearest_to_its_own_size_is_named() -> None:
    """A delay that must be scaled by a tenth is a low-pass, though it gains a little more."""
    several: Any = [SimpleNamespace(name=name, gain=100.0 + more, scale_error=off) for name, more, off in KIN]
    assert _select_in_family(several, STANDARD).name == "bandwidth"


@pytest.mark.parametrize(("off", "name"), [(0.005, "latency"), (0.02, "bandwidth")])
def test_of_one_kin_and_nearly_one_size_the_chain_s_last_is_named(off: float, name: str) -> None:
    several: Any = [
        SimpleNamespace(name=one, gain=100.0, scale_error=by) for one, by in (("bandwidth", 0.0), ("latency", off))
    ]
    assert _select_in_family(several, STANDARD).name == name


def test_of_those_that_are_not_told_apart_the_simplest_is_accepted() -> None:
    gain = 100 * STANDARD.accepted(len(EFFECTS))
    wide, narrow = _evidence(FIRST, gain, 9), _evidence(SECOND, gain - STANDARD.apart / 2, 3)
    behind = _evidence(THIRD, gain - 2 * STANDARD.apart, 1)
    chosen = accept_best((wide, narrow, behind), STANDARD)
    assert chosen is not None
    assert (chosen.name, chosen.alternatives) == (SECOND.name, (FIRST.name,))


def test_of_two_that_are_the_same_the_chain_s_first_is_accepted() -> None:
    gain = 100 * STANDARD.accepted(len(EFFECTS))
    last, first = sorted((FIRST.name, SECOND.name), key=list(BY_NAME).index, reverse=True)
    for more in (0.0, 1e-9 * gain, -1e-9 * gain):
        ranking = sorted(
            (_evidence(BY_NAME[last], gain + more), _evidence(BY_NAME[first], gain)), key=lambda e: -e.gain
        )
        chosen = accept_best(ranking, STANDARD)
        assert chosen is not None
        assert chosen.name == first


@pytest.mark.parametrize(("apart", "same"), [(5e-7, True), (2e-6, False)])
def test_two_are_the_same_within_a_millionth(apart: float, same: bool) -> None:
    gain = 100 * STANDARD.accepted(len(EFFECTS))
    first, last = sorted((FIRST.name, SECOND.name), key=list(BY_NAME).index)
    chosen = accept_best((_evidence(BY_NAME[last], gain * (1 + apart)), _evidence(BY_NAME[first], gain)), STANDARD)
    assert chosen is not None
    assert (chosen.name == first) is same


@pytest.mark.parametrize("effect", [e for e in EFFECTS if e.traits.equivalent_to], ids=lambda e: e.name)
def test_what_says_that_it_is_another_is_named_after_it(effect: type[Effect]) -> None:
    """Beside an iron with currents in it they differ by a fraction of a nat, either way."""
    other = BY_NAME[effect.traits.equivalent_to]
    assert list(BY_NAME).index(other.name) < list(BY_NAME).index(effect.name)
    for more in (-0.3, 0.3):
        both = sorted((_evidence(effect, 2000.0 + more), _evidence(other, 2000.0)), key=lambda e: -e.gain)
        chosen = accept_best(both, STANDARD)
        assert chosen is not None
        assert (chosen.name, chosen.alternatives) == (other.name, (effect.name,))


@pytest.mark.parametrize(("effect", "share"), [(SECOND, 0.15), (FIRST, 0.35)])
def test_a_much_smaller_effect_is_the_form_of_the_first(effect: type[Effect], share: float) -> None:
    first = _accepted(FIRST, 10.0)
    assert _is_form_of_accepted(_accepted(effect, 9.0 * share), _so_far(first))
    assert not _is_form_of_accepted(_accepted(effect, 11.0 * share), _so_far(first))
    assert not _is_form_of_accepted(first, _so_far())


@pytest.mark.parametrize(
    ("effect", "first", "second", "form"),
    [
        (Hysteresis, {"threshold_nT": 1000.0}, {"threshold_nT": 900.0}, True),
        (Hysteresis, {ACTIVE_WINDOW.name: (20.0, 50.0)}, {ACTIVE_WINDOW.name: (80.0, 90.0)}, False),
        (OffsetJump, {"time_s": 20.0}, {"time_s": 50.0}, False),
    ],
)
def test_the_same_effect_at_another_of_its_listed_values_is_a_form(
    effect: type[Effect], first: dict[str, Any], second: dict[str, Any], form: bool
) -> None:
    """At another time it is another event."""
    one, other = (
        replace(each, evidence=replace(each.evidence, candidate=Candidate(effect, tuple(values.items()))))
        for each, values in ((_accepted(effect, 10.0), first), (_accepted(effect, 10.0), second))
    )
    assert _is_form_of_accepted(other, _so_far(one)) is form


def test_noise_that_a_filter_correlates_over_a_few_samples_is_clean_beside_the_filter() -> None:
    """A moving mean over four samples of white noise: a low-pass in the instrument makes it, a motor does not."""
    noise = np.random.default_rng(2).normal(scale=2.0, size=(6003, 3))
    smooth = sum(noise[i : i + 6000] for i in range(4)) / 2.0
    quiet = recording(6000, noise_nT=1e-3)
    start = Baseline.of(problem(replace(quiet, mag_nT=quiet.mag_nT + smooth)))
    slow = [
        any("over 1 s" in why for why in residual_tests(start, [name]).why) for name in ("latency", "motor_current")
    ]
    assert slow == [False, True]


def test_a_window_is_not_settled_anew() -> None:
    """It was found with its effect."""
    posed = problem(n=1500, hidden={"soft_iron": {"matrix": (0.01 * np.eye(3)).tolist(), "active_s": [40.0, 70.0]}})
    start, settings = Baseline.of(posed), iron_candidates()
    windowed = settings["soft_iron"][0].at({ACTIVE_WINDOW.name: (40.0, 70.0)})
    found, beside = judge_settings(start, [windowed]), judge_settings(start, [Candidate(BY_NAME["motor_current"])])
    assert found is not None
    assert beside is not None
    (settled,) = _refit_settings(AcceptedEffect(beside, ()), [AcceptedEffect(found, ())], settings, start)
    assert settled.evidence is found


def test_a_wander_that_the_model_states_is_a_clean_rest() -> None:
    effect = next(one for one in EFFECTS if one.traits.spectrum is not None)
    level = effect.with_role("level")
    assert level is not None
    posed = problem(hidden={effect.name: {level: [2.0] * 3}})
    assert not residual_tests(Baseline.of(posed), ()).clean
    assert residual_tests(Baseline.of(replace(posed, effects=(effect(**{level: (2.0,) * 3}),))), ()).clean


def test_what_one_of_its_kin_takes_is_the_form_of_the_first() -> None:
    one, other = [effect for effect in EFFECTS if effect.traits.family][:2]
    first, second = _accepted(one, 10.0), _accepted(other, 9.0)
    assert _is_form_of_accepted(second, _so_far(first))
    assert [found.alternatives for found in _with_look_alike([first, _accepted(FIRST, 3.0)], second)] == [
        (other.name,),
        (),
    ]


@pytest.mark.parametrize(("cutoff_hz", "order"), [(1.0, 2), pytest.param(2.0, 3, marks=pytest.mark.slow)])
def test_a_low_pass_of_another_order_is_one_class_of_look_alikes(cutoff_hz: float, order: int) -> None:
    """Several poles, on the field between the samples; the library has one pole, at the samples."""
    given = recording()
    fine_s = np.linspace(given.time_s[0], given.time_s[-1], 8 * (len(given) - 1) + 1)
    field = CubicSpline(given.time_s, problem(given).state.field_nT)(fine_s)
    sos = butter(order, cutoff_hz, fs=1 / (fine_s[1] - fine_s[0]), output="sos")
    start = sosfilt_zi(sos)
    late = np.stack([sosfilt(sos, x, zi=start * x[0])[0][::8] for x in field.T], axis=1)
    noise = np.random.default_rng(1).normal(size=late.shape)
    found = select(problem(replace(given, mag_nT=late + noise * 40.0)), COSTLY).accepted
    assert len(found) == 1
    assert {found[0].name, *found[0].alternatives} >= {"latency", "bandwidth"}


@pytest.mark.parametrize(("seconds", "named"), [(0.3, True), (3.0, False)])
def test_what_only_a_conductor_of_seconds_would_explain_is_no_eddy_current(seconds: float, named: bool) -> None:
    given = recording(1500, noise_nT=20.0)
    hidden = seconds * problem(given).state.field_rate_nT_s * np.array([1.0, -0.3, 0.6])
    found = select(problem(replace(given, mag_nT=given.mag_nT + hidden)), COSTLY).accepted
    assert ("eddy_current" in [one.name for one in found]) is named


def test_what_is_in_is_settled_anew_beside_the_next() -> None:
    """A gradient's origin was found with the jump in what it leaves, and would leave a constant of the field."""
    gradient = {"gradient_nT_m": [[0.4, 0.16, -0.12], [0.16, -0.24, 0.08], [-0.12, 0.08, -0.16]]}
    jump = {"time_s": 180.0, "step_nT": [6.0, -4.8, 3.6]}
    hidden = {"field_gradient": {**gradient, "origin_enu_m": [15.0, -10.0, 3.0]}, "offset_jump": jump}
    selection = select(problem(n=2500, hidden=hidden), COSTLY)
    assert {one.name for one in selection.accepted} == set(hidden)
    assert selection.after.clean


def test_a_tone_that_two_currents_have_in_common_is_dropped_beside_both() -> None:
    """With a phase of its own on each axis the one line explains more than either current alone."""
    given = recording()
    t = given.time_s
    phases = np.outer(t, [0.31, 0.53, 0.71]) + np.arange(3.0)
    currents_A = 6.0 + np.column_stack(
        [np.sin(1.4 * t) + 0.5 * np.sin(phases).sum(axis=1), np.cos(1.4 * t) + 0.5 * np.cos(1.3 * phases).sum(axis=1)]
    )
    gains = np.array([[-1.3, 1.9, -0.2], [-1.6, -1.3, 0.9]])
    told = select(problem(replace(given, current_A=currents_A, mag_nT=given.mag_nT + currents_A @ gains)))
    assert told.results[0].name == "steady_tone"
    assert told.results[0].outcome.startswith("withdrawn")
    motors = [(one.name, dict(one.evidence.candidate.nonlinear)["motor"]) for one in told.accepted]
    assert sorted(motors) == [("motor_current", 1), ("motor_current", 2)]
    assert told.after.clean
