"""What of the iron is said to differ beside the effects that were found."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from diagnosis.decision.choice import Selection, accept_best
from diagnosis.decision.conclusion import _is_conventional, conclude, iron_changes
from diagnosis.decision.selection import select
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import HARDLY_MORE, CandidateResult, Evidence, rank_candidates, with_outcomes
from diagnosis.library.candidates import Candidate, propose_candidates
from diagnosis.policy import STANDARD
from diagnosis.problem.formulation import pose_model
from diagnosis.repair.named_effects import explain
from recordings import Recording
from sim.effects import BY_NAME
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import COSTLY, STRENGTH_NT, problem, recording
from tests.nightly import first_daily


def test_a_far_origin_of_a_gradient_is_no_change_of_the_iron() -> None:
    """An origin whose constant is 40 nT along the field: with the iron fitted that is a scale."""
    G = np.array([[0.4, -0.2, 0.1], [-0.2, 0.3, 0.5], [0.1, 0.5, -0.7]])
    along = problem().state.field_enu_nT / STRENGTH_NT
    origin = np.linalg.solve(G, 40.0 * along)
    found = select(problem(hidden={"field_gradient": {"gradient_nT_m": G.tolist(), "origin_enu_m": origin.tolist()}}))
    assert [one.name for one in found.accepted] == ["field_gradient"]
    assert iron_changes(found).changes == ()


@pytest.mark.slow
def test_another_reference_temperature_is_counted_with_its_effect() -> None:
    """``k (T - 26)`` is ``k (T - 20)`` and a hard iron of -6 k; another hard iron is a finding."""
    slope = np.array([2.0, -3.0, 1.5])
    hidden = {"temperature_offset": {"slope_nT_K": slope.tolist(), "reference_degC": 26.0}}
    alone = iron_changes(select(problem(hidden=hidden)))
    assert alone.changes == ()
    assert [one.name for one in alone.conventional] == ["hard_iron"]
    assert alone.conventional[0].evidence.coefficients == pytest.approx(-6 * slope, abs=0.5)
    both = iron_changes(select(problem(hidden={**hidden, "hard_iron": {"offset_nT": [20.0, 30.0, 10.0]}})))
    assert [one.name for one in both.changes] == ["hard_iron"]


@pytest.mark.slow
def test_a_bent_course_of_temperature_is_counted_from_any() -> None:
    """``k d + k2 d^2``, d = T - 20, is no hard iron, though k2 points elsewhere than k; another hard iron is one."""
    quiet, k, k2 = recording(6000), np.array([2.0, -3.0, 1.5]), np.array([0.3, 0.2, -0.3])
    middle_degC = 27.0 + 6.0 * np.sin(0.013 * quiet.time_s)
    warmer_K = (middle_degC - 20.0)[:, None]
    warm = replace(quiet, temperature_degC=middle_degC, mag_nT=quiet.mag_nT + warmer_K * (k + warmer_K * k2))
    alone = iron_changes(select(problem(warm)))
    assert alone.changes == ()
    assert [one.name for one in alone.conventional] == ["hard_iron"]
    both = iron_changes(select(problem(replace(warm, mag_nT=warm.mag_nT + np.array([20.0, 30.0, 10.0])))))
    assert [one.name for one in both.changes] == ["hard_iron"]


def test_a_drift_is_counted_from_any_time() -> None:
    """An iron that was calibrated in the middle of a drift: ``r (t - T / 2)``; another hard iron is a finding."""
    quiet, rate = recording(3000), np.array([0.04, -0.03, 0.02])
    ramp_nT = (quiet.time_s - quiet.time_s.mean())[:, None] * rate
    drifting = replace(quiet, mag_nT=quiet.mag_nT + ramp_nT)
    alone = iron_changes(select(problem(drifting), COSTLY))
    assert alone.changes == ()
    assert alone.conventional[0].evidence.coefficients == pytest.approx(-quiet.time_s.mean() * rate, abs=0.5)
    moved = replace(drifting, mag_nT=drifting.mag_nT + np.array([20.0, 30.0, 10.0]))
    both = iron_changes(select(problem(moved), COSTLY))
    assert [one.name for one in both.changes] == ["hard_iron"]


def test_a_temperature_that_hardly_changes_keeps_its_slope() -> None:
    """A sensor at 5 degrees that the model's iron is right for: most of ``k (T - 20)`` is iron, and goes into it."""
    quiet = recording()
    swing_K, slope = 0.15 * np.sin(0.02 * quiet.time_s), np.array([30.0, -45.0, 20.0])
    mag_nT = quiet.mag_nT + swing_K[:, None] * slope
    posed = problem(replace(quiet, mag_nT=mag_nT, temperature_degC=5 + swing_K))
    (named,) = explain(conclude(select(posed, COSTLY)), ()).named
    assert named.effect.slope_nT_K == pytest.approx(slope, rel=0.05)  # type: ignore[attr-defined]
    (iron,) = named.also
    assert iron.offset_nT == pytest.approx(15 * slope, rel=0.05)  # type: ignore[attr-defined]


def test_one_effect_with_two_parts_is_one_name() -> None:
    """Two motors whose fields differ are one cause, whose second part goes into the model with the first."""
    gains = [{"gain_nT_A": [6.0, -3.0, 4.0], "motor": 1}, {"gain_nT_A": [-4.0, 5.0, 2.0], "motor": 2}]
    posed = problem(hidden={"motor_current": gains})
    conclusion = conclude(select(posed, COSTLY))
    assert {one.name for one in conclusion.accepted} == {"motor_current"}
    (named,) = explain(conclusion, ()).named
    field = sum(
        effect.apply(posed.state, posed.state.field_nT, np.random.default_rng(0), {}) for effect in named.effects
    )
    expected = sum(posed.state.channel(f"current_{g['motor']}_A")[:, None] * np.array(g["gain_nT_A"]) for g in gains)
    assert np.std(field - expected) < 0.1 * np.std(expected)


def test_a_scale_that_differs_is_a_change_of_the_iron() -> None:
    found = select(problem(hidden={"scale": {"error": [1e-3, -1e-3, 5e-4]}}))
    assert found.accepted == ()
    assert [one.name for one in iron_changes(found).changes] == ["scale"]


IRON_NOW = {
    "soft_iron": {"matrix": [[0.012, -0.004, 0.006], [0.003, -0.009, 0.002], [-0.005, 0.007, 0.004]]},
    "hard_iron": {"offset_nT": [51.0, -32.0, 18.0]},
}


FLICKER = {"flicker_noise": {"density_nT_sqrt_hz": [1.0] * 3}}


@cache
def changed_whole(flicker: bool = False) -> Selection:
    """What is selected where the iron changed whole."""
    return select(problem(hidden=IRON_NOW | (FLICKER if flicker else {})), COSTLY)


@pytest.mark.parametrize("flicker", first_daily([False, True]))
def test_of_an_iron_that_changed_whole_both_parts_are_found(flicker: bool) -> None:
    """The offset is a hundredth of the matrix's nats and less; neither is the other's form, for both are linear."""
    found = {one.name: one for one in iron_changes(changed_whole(flicker)).changes}
    assert set(found) == {"soft_iron", "hard_iron"}
    assert found["hard_iron"].evidence.gain < 0.02 * found["soft_iron"].evidence.gain


def test_an_iron_that_changed_whole_is_told_as_it_is() -> None:
    told: dict[str, Any] = {one.name: one.effect for one in explain(conclude(changed_whole()), ()).named}
    assert told["hard_iron"].offset_nT == pytest.approx(IRON_NOW["hard_iron"]["offset_nT"], abs=1.0)
    np.testing.assert_allclose(told["soft_iron"].matrix, IRON_NOW["soft_iron"]["matrix"], atol=2e-5)


def test_an_iron_that_changed_is_no_drift_that_settles_at_once_and_no_loop_wider_than_the_field() -> None:
    found = iron_changes(changed_whole()).changes
    listed = {name for one in found for name in one.alternatives}
    assert all(BY_NAME[name].traits.absorbed for name in listed)


@pytest.mark.parametrize(
    ("effect", "nonlinear", "counted"),
    [
        ("hard_iron_drift", {"time_constant_s": 0.3}, True),
        ("hard_iron_drift", {"time_constant_s": 100.0}, False),
        ("hysteresis", {"threshold_nT": 100_000.0}, True),
        ("hysteresis", {"threshold_nT": 1000.0}, False),
        ("temperature_offset", {"lag_s": 0.0}, False),
    ],
)
def test_what_an_effect_is_counted_from_is_no_likeness(effect: str, nonlinear: dict[str, float], counted: bool) -> None:
    """Of a temperature that hardly changes it is not said: it may be why the iron is another."""
    given = recording()
    posed = problem(replace(given, temperature_degC=10 + 0.01 * np.sin(0.01 * given.time_s)))
    (rival,) = rank_candidates(
        Baseline.of(posed), {effect: [Candidate(BY_NAME[effect], tuple(nonlinear.items()))]}
    ) or [None]
    assert rival is not None
    rival = replace(rival, candidate=Candidate(BY_NAME[effect], tuple(nonlinear.items())))
    assert _is_conventional(rival, posed) is counted


def test_beside_a_colour_a_change_of_the_iron_needs_what_any_effect_needs_there() -> None:
    """What is slow moves a fitted matrix too: 17 nats are a scale where white noise is left alone."""
    found = select(problem(hidden={"scale": {"error": [5e-6, -5e-6, 2.5e-6]}}))
    assert [one.name for one in iron_changes(found).changes] == ["scale"]
    assert iron_changes(replace(found, after=replace(found.after, why=("means over 5 s",)))).changes == ()


@pytest.mark.parametrize(("less", "name"), [(0.02, "regional_field"), (0.2, "field_gradient")])
def test_an_error_of_form_makes_no_gradient_of_a_constant(less: float, name: str) -> None:
    """A gradient has a constant within it: it must gain more beyond that than an error of form does."""
    gradient, constant = _gradient_and_constant()
    chosen = accept_best([replace(gradient, gain=constant.gain / (1 - less)), constant], STANDARD)
    assert chosen is not None
    assert chosen.name == name


@pytest.mark.parametrize(("lead", "listed"), [(-1.1, ()), (0.9, ()), (1.1, ("field_gradient",))])
def test_a_gradient_is_listed_beside_its_constant_where_it_gains_more_than_by_chance(
    lead: float, listed: tuple[str, ...]
) -> None:
    """With nothing beyond the constant it is the constant."""
    gradient, constant = _gradient_and_constant()
    richer = replace(gradient, gain=constant.gain + lead * STANDARD.apart * gradient.V)
    several = sorted([richer, constant], key=lambda one: -one.gain)
    chosen = accept_best(several, STANDARD)
    assert chosen is not None
    assert (chosen.name, chosen.alternatives) == ("regional_field", listed)
    results = [CandidateResult(evidence, evidence.nats, 8.0, "") for evidence in several]
    named = {one.name: one.outcome for one in with_outcomes(results, chosen.name, chosen.alternatives)}[
        "field_gradient"
    ]
    assert (HARDLY_MORE in named) is (not listed)


def _gradient_and_constant() -> list[Evidence]:
    posed = problem(hidden={"regional_field": {"error_enu_nT": [150.0, -80.0, 60.0]}})
    members = {
        key: many for key, many in propose_candidates(posed).items() if key in ("regional_field", "field_gradient")
    }
    return sorted(rank_candidates(Baseline.of(posed), members), key=lambda one: one.name)


def test_an_error_of_the_field_on_a_level_circle_is_listed_beside_the_iron_it_looks_like() -> None:
    """Its form differs in second order alone; at a strength of thirty sigma that is more than ln 100 nats."""
    n, rng = 4000, np.random.default_rng(1)
    heading = np.radians(np.arange(n) * 1.0)
    cos, sin, zero, one = np.cos(heading), np.sin(heading), np.zeros(n), np.ones(n)
    R_wb = np.stack([cos, -sin, zero, sin, cos, zero, zero, zero, one], axis=1).reshape(n, 3, 3)
    field = np.array([500.0, 20_000.0, -45_000.0])
    soft = np.eye(3) + 0.05 * rng.normal(size=(3, 3))
    mag = ((field + np.array([500.0, -250.0, 100.0])) @ R_wb) @ soft.T + 2.0 * rng.normal(size=(n, 3))
    q = np.column_stack([np.cos(heading / 2), zero, zero, np.sin(heading / 2)])
    model = ModelSpec.model_validate({"effects": {"soft_iron": {"matrix": (soft - np.eye(3)).tolist()}}})
    level = pose_model(Recording(time_s=np.arange(n) / 10.0, mag_nT=mag, att_q=q), model, field, None)
    found = iron_changes(select(level)).changes
    assert "regional_field" in {name for one in found for name in (one.name, *one.alternatives)}


@pytest.mark.parametrize("seed", first_daily(range(3)))
@pytest.mark.parametrize("offset_nT", first_daily([200.0, 0.0]))
def test_of_slow_noise_a_slow_log_makes_no_change_of_the_iron(offset_nT: float, seed: int) -> None:
    """Samples 2 s apart: no means of the evidence's last as long as the turns do, over which the noise wanders."""
    made = recording(700, seed=seed, hidden={"flicker_noise": {"density_nT_sqrt_hz": [6.0] * 3}})
    slow = replace(made, time_s=20 * made.time_s, mag_nT=made.mag_nT + offset_nT * np.array([1.0, -1.0, 1.0]))
    names = [one.name for one in iron_changes(select(problem(slow), COSTLY)).changes]
    assert names == ["hard_iron"] * bool(offset_nT)


def test_a_hard_iron_that_is_off_is_told_beside_noise_whose_mean_is_known_far_better() -> None:
    """Gauss-Markov noise of 10 s has a mean that is known to a seventh of its size in 400 s."""
    hidden = {
        "hard_iron": {"offset_nT": [25.0, -20.0, 15.0]},
        "gauss_markov_noise": {"std_nT": [6.0] * 3, "correlation_time_s": 10.0},
    }
    posed = problem(hidden=hidden)
    found = conclude(select(posed, COSTLY))
    assert [one.name for one in found.iron] == ["hard_iron"]
    assert found.noise is not None
    quiet = conclude(select(problem(hidden={"gauss_markov_noise": hidden["gauss_markov_noise"]}), COSTLY))
    assert (quiet.iron, quiet.noise is not None) == ((), True)
