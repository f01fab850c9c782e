"""Candidates as columns: what they span is what the effect does, and what is proposed is what was measured."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from diagnosis.decision.conclusion import survival
from diagnosis.library.candidates import (
    Candidate,
    amplitude_and_phase,
    iron_candidates,
    propose_candidates,
)
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects import BY_NAME, EFFECTS
from sim.effects.base import Effect
from tests.diagnosis.synthetic import problem, recording, without_attitude

PHASED = [effect for effect in EFFECTS if effect.with_role("phase") and not effect.search_role()]
WAVES = [effect for effect in PHASED if effect.with_role("period")]
TANGENT = [effect for effect in EFFECTS if effect.tangents]


def _applied(name: str, values: dict[str, Any], posed: LinearProblem) -> Array:
    effect = BY_NAME[name](**values)
    early = effect.stage in ("field", "vehicle")
    signal = posed.state.field_nT if early else posed.clean_nT
    return effect.apply(posed.state, signal, np.random.default_rng(0), {})


@pytest.mark.parametrize("effect", [e for e in EFFECTS if e.linear and not e.with_role("phase")], ids=lambda e: e.name)
def test_columns_times_coefficients_are_what_the_effect_does(effect) -> None:  # type: ignore[no-untyped-def]
    posed = problem()
    acting = effect(**effect.example)
    rest = {p.name: getattr(acting, p.name) for p in acting.parameters() if p.name not in acting.linear}
    candidate = Candidate(effect, tuple(rest.items()), forms=tuple(effect.forms))
    early = effect.stage in ("field", "vehicle")
    signal = posed.state.field_nT if early else posed.clean_nT
    columns = candidate.contribution_nT(posed)
    done = acting.apply(posed.state, signal, np.random.default_rng(0), {})
    by_neighbours = effect.continuous and not effect.traits.correlates_noise
    off = (1e-3 if by_neighbours else 1e-9) * np.abs(done).max()
    assert columns @ acting.coefficients() == pytest.approx(done, rel=1e-6, abs=off)
    assert candidate.to_effect(acting.coefficients()).coefficients() == pytest.approx(acting.coefficients())


@pytest.mark.parametrize("phase_deg", [-140.0, 10.0, 75.0])
def test_sine_and_cosine_give_amplitude_and_phase_back(phase_deg: float) -> None:
    amplitude, phase = np.array([2.0, -1.0, 0.5]), np.radians(phase_deg)
    found, found_deg = amplitude_and_phase(np.array([amplitude * np.cos(phase), amplitude * np.sin(phase)]))
    same = np.exp(1j * np.radians(found_deg)) * found
    assert same == pytest.approx(np.exp(1j * phase) * amplitude)
    assert abs(found_deg) <= 90.0


@pytest.mark.parametrize("effect", PHASED, ids=lambda e: e.name)
def test_the_columns_of_a_wave_span_every_phase(effect) -> None:  # type: ignore[no-untyped-def]
    posed = problem()
    candidate = Candidate(effect)
    columns = candidate.contribution_nT(posed).reshape(-1, 2 * len(effect.linear_units()))
    wave = _applied(effect.name, {**effect.example, effect.with_role("phase"): 33.0}, posed).ravel()
    period = {k: v for k, v in effect.example.items() if k not in effect.linear and k != effect.with_role("phase")}
    if not period or all(getattr(effect(), k) == v for k, v in period.items()):
        c = np.linalg.lstsq(columns, wave, rcond=1e-12)[0]
        assert columns @ c == pytest.approx(wave, abs=1e-4 * np.abs(wave).max())


@pytest.mark.parametrize("effect", TANGENT, ids=lambda e: e.name)
def test_small_angles_add_up(effect) -> None:  # type: ignore[no-untyped-def]
    """Tangents are right to first order: the error of a combination is of second."""
    posed = problem(noise_nT=0.01)
    c = np.array([0.4, -0.7, 0.5])
    made = Candidate(effect).to_effect(c)
    early = effect.stage in ("field", "vehicle")
    signal = posed.state.field_nT if early else posed.clean_nT
    done = made.apply(posed.state, signal, np.random.default_rng(0), {})
    assert np.abs(Candidate(effect).contribution_nT(posed) @ c - done).max() < 1e-3 * np.abs(done).max()


def _beside_base(name: str, posed: LinearProblem) -> Array:
    """What the base leaves (3 n, k) of an effect's columns."""
    columns = Candidate(BY_NAME[name]).columns(posed)
    flat = columns.reshape(len(columns), -1)
    Q = np.linalg.qr(posed.base)[0]
    return np.asarray((flat - Q @ (Q.T @ flat)).reshape(-1, columns.shape[2]))


def test_an_error_of_the_field_and_one_of_the_attitude_span_the_same_plane_beside_iron() -> None:
    """Both turn the field by a constant of the earth's frame; its part along the field is a scale of the iron."""
    posed = problem(noise_nT=0.01)
    field, turn = (_beside_base(name, posed) for name in ("regional_field", "attitude_misalignment"))
    for columns in (field, turn):
        size = np.linalg.svd(columns / np.linalg.norm(columns), compute_uv=False)
        assert size[1] > 0.1
        assert size[2] < 1e-5
    F = posed.state.field_enu_nT
    assert np.linalg.norm(field @ F) < 1e-6 * np.linalg.norm(field) * np.linalg.norm(F)
    plane = np.linalg.svd(field, full_matrices=False)[0][:, :2]
    assert np.linalg.norm(turn - plane @ (plane.T @ turn)) < 1e-3 * np.linalg.norm(turn)


def test_coefficients_are_brought_into_bounds_and_known_to_be_beyond_them() -> None:
    (effect,) = [e for e in EFFECTS if e.linear and "position" in e.needs and e.search_role() == "place"]
    candidate = Candidate(effect, ((effect.with_role("place"), (0.0, 0.0, -9.0)),))
    low, high = candidate.bounds[0]
    assert candidate.within_bounds(np.array([high, low, 0.0]))
    assert not candidate.within_bounds(np.array([1.01 * high, 0.0, 0.0]))
    assert candidate.to_effect(np.array([1.01 * high, 0.0, 0.0])).coefficients() == pytest.approx([high, 0.0, 0.0])


@pytest.mark.parametrize("effect", WAVES, ids=lambda e: e.name)
@pytest.mark.parametrize(("sine", "cosine"), [(0.3, 0.2), (0.1, 7.0), (1.5, -2.0)])
def test_a_short_stretch_of_a_wave_that_is_too_high_is_one_of_a_shorter_wave(
    effect: type[Effect], sine: float, cosine: float
) -> None:
    """Its course is the same to a hundredth of it, in a run of ten minutes."""
    candidate, posed = Candidate(effect), problem(recording(1200))
    of_one = np.array(candidate.bounds)[:, 1] * [0.6, -0.3, 0.7]
    c = np.concatenate([sine * of_one, cosine * of_one])
    made = candidate.to_effect(c)
    assert candidate.within_bounds(c)
    assert np.abs(made.coefficients()).max() < np.array(candidate.bounds).max()
    course = candidate.contribution_nT(posed) @ c
    given = made.contribution(posed.state, posed.clean_nT, np.random.default_rng(0), {})
    assert np.abs(given - course).max() < 0.01 * np.abs(course).max()


@pytest.mark.parametrize("effect", TANGENT, ids=lambda effect: effect.name)
def test_a_turn_beyond_its_bounds_is_not_possible_and_is_made_within_them(effect: type[Effect]) -> None:
    candidate = Candidate(effect)
    ((name, small),) = effect.tangents.items()
    high = next(p.high for p in effect.parameters() if p.name == name)
    c = np.linalg.solve(np.array(small).T, [high, 0.0, 0.0])
    assert candidate.within_bounds(0.99 * c)
    assert not candidate.within_bounds(1.1 * c)
    assert np.allclose(getattr(candidate.to_effect(1.1 * c), name), [high, 0.0, 0.0])


def test_a_delay_of_the_wrong_sign_is_not_possible() -> None:
    delays = [e for e in EFFECTS if not e.linear and not e.tangents and e.search]
    assert delays
    for effect in delays:
        assert Candidate(effect).within_bounds(np.array([1.0]))
        assert not Candidate(effect).within_bounds(np.array([-1.0]))


def test_what_was_not_measured_is_not_proposed() -> None:
    given = recording()
    causes = {"temperature_degC": "temperature_degC", "current_A": "current_1_A", "pos_enu_m": "position"}
    for column, need in causes.items():
        posed = problem(replace(given, **{column: None}))
        assert propose_candidates(problem(given)).keys() - propose_candidates(posed).keys()
        assert not any(need in BY_NAME[name].needs for name in propose_candidates(posed))
        assert any(posed.missing_inputs(effect) == (need,) for effect in EFFECTS)


def test_without_attitude_nothing_that_needs_it_is_proposed_but_a_field_that_changes_in_time() -> None:
    names = propose_candidates(problem(without_attitude(recording())))
    assert names
    assert [name for name in names if {"attitude", "position"} & set(BY_NAME[name].needs)] == ["diurnal_drift"]


def test_a_path_that_is_too_short_has_no_places() -> None:
    given = recording()
    assert given.pos_enu_m is not None
    still = replace(given, pos_enu_m=given.pos_enu_m * 0.01)
    assert any("position" in BY_NAME[name].needs for name in propose_candidates(problem(given)))
    assert not any("position" in BY_NAME[name].needs for name in propose_candidates(problem(still)))


def test_names_left_out_and_noises_are_not_proposed() -> None:
    posed = problem()
    some = next(iter(propose_candidates(posed)))
    assert some not in propose_candidates(posed, frozenset({some}))
    assert not any(BY_NAME[name].stochastic for name in propose_candidates(posed))


def test_each_motor_and_all_of_them_are_tried() -> None:
    posed = problem()
    driven = [name for name in propose_candidates(posed) if BY_NAME[name].with_role("motor")]
    assert driven
    for name in driven:
        motor = BY_NAME[name].with_role("motor")
        assert [dict(one.nonlinear)[motor] for one in propose_candidates(posed)[name]] == [0, 1, 2]


@pytest.mark.parametrize("name", iron_candidates())
def test_the_base_takes_up_whole_what_is_called_iron(name: str) -> None:
    posed = problem(noise_nT=0.01)
    assert survival(posed, iron_candidates()[name][0]) < 1e-3


def test_the_base_leaves_most_of_what_a_free_motion_shows() -> None:
    posed = problem()
    driven = [members[0] for name, members in propose_candidates(posed).items() if BY_NAME[name].with_role("motor")]
    assert all(survival(posed, candidate) > posed.policy.little for candidate in driven)


def test_a_delay_is_driven_by_the_rate_and_not_by_the_noise_of_an_attitude() -> None:
    given = recording()
    exact = problem(given)
    q = Rotation.from_quat(np.array(given.att_q), scalar_first=True)
    shake = Rotation.from_rotvec(1e-3 * np.random.default_rng(0).normal(size=(len(given), 3)))
    noisy = replace(given, att_q=(q * shake).as_quat(scalar_first=True), gyro_rad_s=exact.state.rate_rad_s)
    late = Candidate(BY_NAME["latency"], (("delay_s", 0.1),))
    clean, seen = (late.contribution_nT(one)[5:] for one in (exact, problem(noisy)))
    assert np.sqrt(((seen - clean) ** 2).mean()) < 0.05 * np.sqrt((clean**2).mean())


def test_without_attitude_no_loop_is_as_narrow_as_the_noise() -> None:
    """The field's course is the measurement there, and a narrow loop would follow its noise."""
    looped = next(effect.name for effect in EFFECTS if effect.stage == "sensor" and "gain" in effect.linear)
    noisy = recording(noise_nT=50.0)
    with_it, bare = (
        propose_candidates(problem(noisy))[looped],
        propose_candidates(problem(without_attitude(noisy)))[looped],
    )
    least = min(float(np.min(dict(one.nonlinear)["threshold_nT"])) for one in bare)
    assert least > 15 * 50.0
    assert len(bare) < len(with_it)


def test_a_lag_of_the_measurements_own_rate_is_not_tried() -> None:
    """A rate that comes late holds the noise of its own sample: 40 nats of an eddy current in a white rover's log."""
    given = without_attitude(recording(300))
    lagged = [e for e in EFFECTS if "rate" in e.needs and len(e.search) == 1]
    assert lagged
    turning = replace(given, gyro_rad_s=np.full((300, 3), 0.1))
    for effect in lagged:
        assert len(propose_candidates(problem(given))[effect.name]) == 1
        assert len(propose_candidates(problem(turning))[effect.name]) == len(next(iter(effect.search.values())))


@pytest.mark.parametrize(("sigma_nT", "least_nT"), [(4.9, 100.0), (5.1, 300.0)])
def test_without_attitude_a_loop_is_twenty_times_the_noise(sigma_nT: float, least_nT: float) -> None:
    posed = replace(problem(without_attitude(recording(1000))), sigma_nT=np.array([sigma_nT]))
    values = [np.min(dict(one.nonlinear)["threshold_nT"]) for one in propose_candidates(posed)["hysteresis"]]
    assert min(values) == least_nT
