"""A candidate in one recording of a lot: beside a rest of its own, and by how many nats its coefficients explain."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.evidence.held_out import search_price
from diagnosis.evidence.hypothesis import Hypothesis
from diagnosis.evidence.noise_model import NoiseModel
from diagnosis.library.candidates import Candidate
from diagnosis.policy import STANDARD
from diagnosis.problem.formulation import pose
from diagnosis.problem.known import Known, Level
from diagnosis.problem.linear import LinearProblem
from diagnosis.several.coefficients import CoefficientEstimate
from diagnosis.several.pooled_effect import CandidateInRecording, PooledEffect, columns_in, cross_predicted
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.effects.currents import MotorCurrent
from sim.effects.iron import HardIron
from tests.diagnosis.synthetic import FIELD_ENU_NT, STRENGTH_NT, problem, recording, without_attitude

N = 2000
GIVEN, MOTOR = problem(n=N), Candidate(MotorCurrent)
TO = np.array([1.0, 0.5, -1.0])
JUMP, RAMP, SLOW = (
    course[:, None, None] * np.eye(3)
    for course in ((np.arange(N) > 1200).astype(float), np.linspace(-0.5, 0.5, N), np.sin(np.linspace(0, 7, N)))
)


def _walk(step: float) -> Array:
    return np.asarray(step * np.cumsum(np.random.default_rng(3).normal(size=(N, 3)), axis=0))


def _with(added: Array, accepted_columns: tuple[Array, ...] = ()) -> ColouredBaseline:
    return ColouredBaseline.of(replace(GIVEN, target=GIVEN.target + added), list(accepted_columns))


def _asked(coloured_baseline: ColouredBaseline, columns: Array) -> CandidateInRecording:
    return CandidateInRecording.of(MOTOR, coloured_baseline, columns)


def _badly(coloured_baseline: ColouredBaseline, hypothesis: Hypothesis) -> Hypothesis:
    """The same with a walk that is not there."""
    noise_model = replace(
        hypothesis.noise_model,
        slow=hypothesis.noise_model.slow + np.r_[np.zeros(hypothesis.noise_model.tau_s.size - 1), 1e4],
    )
    return replace(
        Hypothesis.with_noise_model(coloured_baseline.rows, coloured_baseline.accepted_columns, noise_model),
        noise_model=noise_model,
    )


@pytest.mark.parametrize("step", [0.0, 0.5])
def test_the_rest_beside_a_jump_is_the_one_that_is_there(step: float) -> None:
    coloured_baseline = _with(_walk(step) + 10 * JUMP @ TO)
    tau_s = 4 * N * coloured_baseline.rows.interval_s
    there = NoiseModel(
        np.array([tau_s]), np.ones(3), np.full((3, 1), step**2 * tau_s / (2 * coloured_baseline.rows.interval_s))
    )
    true = Hypothesis.with_noise_model(coloured_baseline.rows, coloured_baseline.columns_with(JUMP), there)
    assert _asked(coloured_baseline, JUMP).hypothesis.log_likelihood > true.log_likelihood - STANDARD.apart


def test_a_slow_course_holds_nothing_beside_a_wander() -> None:
    assert _asked(_with(_walk(1.0)), SLOW).held_out_gain < STANDARD.apart


def test_what_a_rest_that_was_found_badly_lacks_is_nothing_that_a_candidate_holds_or_explains() -> None:
    coloured_baseline = _with(0.0 * TO)
    one = _asked(replace(coloured_baseline, hypothesis=_badly(coloured_baseline, coloured_baseline.hypothesis)), SLOW)
    assert one.held_out_gain < STANDARD.apart


def test_coefficients_as_they_are_explain_what_no_colour_would() -> None:
    """A ramp of ten sigma: thousands of nats in the noise that it leaves, a hundred over a rest that wanders."""
    one = _asked(_with(10 * RAMP @ TO), RAMP)
    assert one.held_out_gain > STANDARD.coloured_nats
    pooled = PooledEffect(MOTOR, {0: one, 1: one}, 0.0)
    nats = pooled.predicted([0, 1]).gains[0] * pooled.estimates[0].inflation(one.estimate.c)
    assert nats == pytest.approx(one.held_out_gain, abs=2 * STANDARD.apart)
    assert pooled.predicted([0]).gains[0] <= 0.0


def test_what_is_left_of_the_same_course_inflates() -> None:
    """A current's field that comes a quarter of its period late."""
    late = np.roll(GIVEN.state.current_A.sum(axis=1), 50)[:, None] * TO
    columns = ColouredBaseline.of(GIVEN, []).rows.bin(MOTOR.columns(GIVEN))
    assert _asked(_with(late - late.mean(axis=0)), columns).inflation > 2
    assert _asked(_with(0 * late), columns).inflation < 2


def test_a_joint_pays_for_its_search_and_is_as_good_within_what_is_left() -> None:
    """The search compared all settings of the recordings, each of which had been searched for."""
    found = PooledEffect.of([replace(MOTOR, tried=200), MOTOR.at({"motor": 1})], [_with(0.0 * TO)])
    assert found.price == search_price(400, 3, STANDARD) > search_price(200, 3, STANDARD)
    in_recording: Any = {i: SimpleNamespace(inflation=by) for i, by in enumerate((2.0, 4.0))}
    assert pytest.approx(3.0) == PooledEffect(MOTOR, in_recording, 0.0).V


def test_the_likeliest_setting_is_the_one_that_is_there_and_the_least_likely_one_that_no_recording_holds() -> None:
    """All motors together rather than one of them."""
    hidden = {"motor_current": {"gain_nT_A": [3.0, -2.0, 4.0]}}
    problems = [problem(recording(1200, seed=seed, hidden=hidden)) for seed in (1, 2)]
    one, gone = MOTOR.at({"motor": 1}), MOTOR.at({"motor": 9})
    posed = [ColouredBaseline.of(each, []) for each in problems]
    likely = cross_predicted([one, gone, MOTOR], posed)
    assert likely[gone] == -np.inf
    assert likely[MOTOR] > likely[one] > 0.0
    found = PooledEffect.of([one, gone, MOTOR], posed)
    assert found.candidate == MOTOR
    assert found.gain > PooledEffect.of([one], posed).gain


def test_coefficients_are_known_no_better_than_what_is_left_allows() -> None:
    """Of parts that say the same: four times the variance that the rest states."""
    parts = [CoefficientEstimate(5.0 * np.eye(2), np.full(2, 5.0))] * 4
    in_recording: Any = SimpleNamespace(parts=parts, inflation=4.0)
    one = PooledEffect(MOTOR, {0: in_recording}, 0.0).estimates[0]
    assert one.inflation(np.ones(2)) == pytest.approx(4.0)


def test_the_strength_of_what_strength_and_dip_do_not_share_is_its_own() -> None:
    """A constant of the sensor is iron; one that has another sign in the dip is none."""
    given = recording(N)
    level = Level.of(problem(given).state.R_wb, FIELD_ENU_NT, STANDARD)
    posed: LinearProblem = pose(without_attitude(given), Known(FIELD_ENU_NT, STRENGTH_NT, level=level))
    coloured_baseline = ColouredBaseline.of(posed, [])
    iron = coloured_baseline.rows.bin(Candidate(HardIron).columns(posed))
    in_recording = SimpleNamespace(baseline=coloured_baseline, estimate=SimpleNamespace(c=TO))
    same, other = (
        CandidateInRecording.strength.func(SimpleNamespace(**vars(in_recording), columns=iron * signs))  # type: ignore[attr-defined]
        for signs in (np.ones((2, 1)), np.array([[1.0], [-1.0]]))
    )
    assert same < 1e-3 * other


def test_the_inflation_is_what_a_column_shifted_in_time_gains_over_half_a_nat() -> None:
    """A column of pure noise gains half a nat on average; three columns one and a half."""
    late = np.roll(GIVEN.state.current_A.sum(axis=1), 50)[:, None] * TO
    one = _asked(_with(late - late.mean(axis=0)), ColouredBaseline.of(GIVEN, []).rows.bin(MOTOR.columns(GIVEN)))
    shifted = one.baseline.surrogate_products(MOTOR, one.columns, one.hypothesis)
    nats = [N_g[:-1, -1] @ np.linalg.solve(N_g[:-1, :-1], N_g[:-1, -1]) / 2 for N_g in shifted]
    assert one.inflation == pytest.approx(np.mean(nats) / (3 / 2))


def test_the_strength_is_the_rms_of_the_course_that_a_refitted_base_leaves() -> None:
    """In units of the noise, over all samples; what the base follows counts for nothing."""
    coloured_baseline = _with(4 * SLOW @ TO)
    one = _asked(coloured_baseline, SLOW)
    course = (SLOW[:, 0, 0] - SLOW[:, 0, 0].mean())[:, None] * one.estimate.c
    assert one.strength <= np.sqrt(np.mean(course**2)) * 1.001
    left = []
    for axis in range(3):
        B, added = GIVEN.base, SLOW[:, axis] @ one.estimate.c
        left.append(added - B @ np.linalg.lstsq(B, added, rcond=None)[0])
    assert one.strength == pytest.approx(np.sqrt(np.mean(np.square(left))), rel=0.02)


def test_a_candidate_that_no_recording_holds_has_no_width_and_explains_nothing() -> None:
    nowhere = PooledEffect.beside(MOTOR.at({"motor": 9}), [], [GIVEN])
    assert (nowhere.width, nowhere.estimates, nowhere.here) == (0, {}, {})


@pytest.mark.parametrize(
    ("settings", "there"),
    [({}, True), ({"motor": 1}, True), ({"motor": 9}, False)],
)
def test_a_setting_is_asked_where_its_motor_is(settings: dict[str, object], there: bool) -> None:
    found = columns_in(Candidate(MotorCurrent, tuple(settings.items())), GIVEN)
    assert (found is not None) is there


def test_a_channel_that_a_recording_lacks_or_that_is_off_is_not_asked() -> None:
    channel = next(effect for effect in EFFECTS if effect.with_role("channel"))
    assert columns_in(Candidate(channel, ((channel.with_role("channel"), "no such"),)), GIVEN) is None
    off = {name: 0.0 * values for name, values in GIVEN.state.channels.items()}
    assert columns_in(MOTOR, replace(GIVEN, state=replace(GIVEN.state, channels=off))) is None


@pytest.mark.parametrize(("without", "held", "gain"), [(2.0, 3.0, 6.0), (7.0, 3.0, 5.0)])
def test_a_candidate_of_a_lot_gains_by_common_or_by_own_coefficients_less_its_price(
    without: float, held: float, gain: float
) -> None:
    """Two of one column with coefficient 3 and unit information each: the other's explains 4.5 nats."""
    alike = CoefficientEstimate(np.eye(1), np.array([3.0]))
    one: Any = SimpleNamespace(estimate=alike, null_gain=without / 2, held_out_gain=held)
    assert PooledEffect(MOTOR, {0: one, 1: one}, 1.0).gain == gain


@pytest.mark.parametrize(("size", "columns"), [(0.0, SLOW), (10.0, RAMP)])
def test_a_noise_model_that_needs_the_candidate_explains_the_recording_without_it_worse(
    size: float, columns: Array
) -> None:
    """A ramp that is not in is a wander to the rest, which is thousands of nats better than white noise."""
    coloured_baseline = _with(size * columns @ TO)
    one = _asked(coloured_baseline, columns)
    without = Hypothesis.with_noise_model(
        coloured_baseline.rows, coloured_baseline.accepted_columns, one.hypothesis.noise_model
    )
    lost = coloured_baseline.hypothesis.log_likelihood - without.log_likelihood
    assert one.null_gain == pytest.approx(max(lost, 0.0))
    assert bool(one.null_gain > 100.0) is (size > 0.0)
    held = coloured_baseline.hypothesis.held_out_log_likelihood
    best = max(held, without.held_out_log_likelihood)
    assert one.held_out_gain == pytest.approx(one.hypothesis.held_out_log_likelihood - best)


def test_an_estimate_sums_the_parts_of_the_recording() -> None:
    one = _asked(_with(2 * SLOW @ TO), SLOW)
    np.testing.assert_array_equal(one.estimate.N, np.sum([part.N for part in one.parts], axis=0))
    np.testing.assert_array_equal(one.estimate.g, np.sum([part.g for part in one.parts], axis=0))
    assert one.estimate.c == pytest.approx(2 * TO, abs=0.5)
