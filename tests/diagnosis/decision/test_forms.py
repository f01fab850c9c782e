"""An effect's fuller form: asked for only where something is left, taken where it tells, never a second name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.decision.choice import AcceptedEffect, Selection, residual_tests
from diagnosis.decision.forms import _refined_settings, complete_forms
from diagnosis.decision.selection import select
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import Evidence, judge_settings
from diagnosis.library.candidates import Candidate, propose_candidates
from sim.effects import BY_NAME
from sim.effects.currents import MotorCurrent
from sim.effects.nonlinearity import Hysteresis
from tests.diagnosis.synthetic import ALL_BUT_SEVEN, problem, recording


def _so_far(start: Baseline, *found: Evidence) -> Selection:
    """A selection of effects that were found one after the other."""
    tests = residual_tests(start, ())
    return Selection(tuple(AcceptedEffect(one, ()) for one in found), start, start, tests, tests, (), frozenset())


def _found(hidden: dict[str, dict[str, object]]) -> Selection:
    return select(problem(hidden=hidden), ALL_BUT_SEVEN)


@pytest.mark.parametrize(
    ("name", "plain", "fuller", "forms"),
    [
        pytest.param(
            "motor_current",
            {"gain_nT_A": [4.0, -2.0, 3.0], "motor": 1},
            {"square_nT_A2": [0.5, 0.9, -0.8]},
            "bent line",
            marks=pytest.mark.slow,
        ),
        (
            "hysteresis",
            {"gain": [0.003, 0.002, 0.004], "threshold_nT": 800.0},
            {"second_gain": [3e-4, 3e-4, 3e-4], "second_threshold_nT": 9000.0},
            "second play",
        ),
        pytest.param(
            "current_ripple",
            {"amplitude_nT_A": [4.0, -2.0, 3.2], "frequency_hz": 1.7, "motor": 2},
            {"second_sine_nT_A": [0.3, 0.2, 0.4]},
            "second harmonic",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "current_ripple",
            {"amplitude_nT_A": [4.0, -2.0, 3.2], "frequency_hz": 1.7, "motor": 2},
            {"drift_hz_s": 6e-6},
            "drift",
            marks=pytest.mark.slow,
        ),
        ("nonlinearity", {"third_order": [2e-3, 1e-3, 2e-3]}, {"kink": [4e-4, -4e-4, 3e-4]}, "kink"),
    ],
)
def test_a_form_goes_under_the_name_of_the_effect(
    name: str, plain: dict[str, object], fuller: dict[str, object], forms: str
) -> None:
    selection = _found({name: plain | fuller})
    (one,) = selection.accepted
    assert (one.name, one.evidence.candidate.forms) == (name, (forms,))
    assert selection.after.clean
    effect = one.evidence.candidate.to_effect(one.evidence.coefficients)
    assert effect.forms_in_use[1:] == (forms,)
    simple = _found({name: plain})
    assert [(each.name, each.evidence.candidate.forms) for each in simple.accepted] == [(name, ())]


def test_a_form_takes_nothing_from_what_is_no_form_of_it() -> None:
    selection = _found(
        {
            "motor_current": {"gain_nT_A": [4.0, -2.0, 3.0], "motor": 1},
            "offset_jump": {"time_s": 250.0, "step_nT": [3.0, 2.0, -2.0]},
        }
    )
    assert sorted(one.name for one in selection.accepted) == ["motor_current", "offset_jump"]


def test_a_candidate_has_the_columns_of_its_forms_and_gives_their_parameters_back() -> None:
    posed = problem(recording(noise_nT=0.5))
    plain = Candidate(Hysteresis, (("threshold_nT", 800.0), ("second_threshold_nT", 5000.0)))
    fuller = replace(plain, forms=("second play",))
    c = np.array([0.01, 0.02, 0.03, 0.004, 0.005, 0.006])
    effect = fuller.to_effect(c)
    assert effect == Hysteresis((0.01, 0.02, 0.03), 800.0, (0.004, 0.005, 0.006), 5000.0)
    assert fuller.columns(posed).shape[2] == plain.columns(posed).shape[2] + 3
    np.testing.assert_allclose(
        fuller.contribution_nT(posed) @ c,
        effect.contribution(posed.state, posed.clean_nT, np.random.default_rng(0), {}),
        atol=0.01,  # of the course by neighbouring samples, and 150 nT
    )


def test_no_candidate_begins_with_a_form() -> None:
    assert all(not one.forms for several in propose_candidates(problem()).values() for one in several)


def test_a_number_that_is_moved_stays_within_its_bounds() -> None:
    """A temperature without a limit to its lag: the longer the better, up to what the effect takes."""
    posed = problem(hidden={"hard_iron_drift": {"rate_nT_h": [300.0, -200.0, 400.0]}})
    lags = (("lag_s", 90_000.0), ("second_lag_s", 90_000.0))
    moved = _refined_settings(Baseline.of(posed), Candidate(BY_NAME["temperature_offset"], lags, forms=("second lag",)))
    assert all(0 < value <= 1e5 for _, value in moved.nonlinear)
    assert np.isfinite(moved.columns(posed)).all()


@pytest.mark.parametrize(("bend", "kept"), [((0.5, 0.9, -0.8), ("bent line",)), ((0.0, 0.0, 0.0), ())])
def test_a_form_that_does_not_tell_is_given_back(bend: tuple[float, ...], kept: tuple[str, ...]) -> None:
    """Of the kind that was taken while another effect was not yet in."""
    posed = problem(hidden={"motor_current": {"gain_nT_A": [4.0, -2.0, 3.0], "motor": 1, "square_nT_A2": list(bend)}})
    start = Baseline.of(posed)
    bent = judge_settings(start, [Candidate(MotorCurrent, (("motor", 1),), forms=("bent line",))])
    assert bent is not None
    found = complete_forms(_so_far(start, bent))
    (one,) = found.accepted
    assert one.evidence.candidate.forms == kept
    assert found.after.clean
    if not kept:
        effect = one.evidence.candidate.to_effect(one.evidence.coefficients)
        assert effect.gain_nT_A == pytest.approx((4.0, -2.0, 3.0), abs=0.3)  # type: ignore[attr-defined]


def test_what_was_found_twice_is_there_once_when_its_form_is_given_back() -> None:
    posed = problem(hidden={"motor_current": {"gain_nT_A": [4.0, -2.0, 3.0], "motor": 1}})
    start = Baseline.of(posed)
    plain = Candidate(MotorCurrent, (("motor", 1),))
    both = [judge_settings(start, [one]) for one in (replace(plain, forms=("bent line",)), plain)]
    (one,) = complete_forms(_so_far(start, *(one for one in both if one is not None))).accepted
    assert one.evidence.candidate.forms == ()
