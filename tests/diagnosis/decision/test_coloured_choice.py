"""Which candidate stands, alone or beside another, and which are its look-alikes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from diagnosis.decision.coloured_choice import (
    NO_GAIN_ALONG_FIELD,
    REVISABLE_REFUSALS,
    CandidateTest,
    CandidateTrial,
)
from diagnosis.decision.selection import select
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline, best_of_each_name, screen
from diagnosis.evidence.held_out import TOO_LITTLE, rank_candidates
from diagnosis.library.candidates import propose_candidates
from diagnosis.policy import STANDARD
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects import EFFECTS
from tests.diagnosis.synthetic import COSTLY, problem, recording
from tests.nightly import first_daily

ERROR = {"error_enu_nT": [60.0, -40.0, 20.0]}


@pytest.mark.parametrize("refusal", first_daily([TOO_LITTLE, NO_GAIN_ALONG_FIELD]))
def test_of_two_effects_each_may_stand_beside_the_other_alone(refusal: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The larger is refused for what the other leaves, and is in once that one is; of too little nothing is asked."""
    gradient = {"gradient_nT_m": [[0.4, -0.2, 0.1], [-0.2, 0.3, 0.5], [0.1, 0.5, -0.7]]}
    jump = {"time_s": 120.0, "step_nT": [6.0, -6.0, 3.0]}
    posed, of = problem(n=2000, hidden={"field_gradient": gradient, "offset_jump": jump}), CandidateTest.of

    def refusing(self: CandidateTest, one: CandidateFit) -> CandidateTrial:
        sole = not self.baseline.accepted_columns and one.evidence.name == "field_gradient"
        return replace(of(self, one), refusal=refusal) if sole else of(self, one)

    monkeypatch.setattr(CandidateTest, "of", refusing)
    first = [one.name for one in select(posed, COSTLY).accepted][:1]
    assert (first == ["field_gradient"]) is (refusal in REVISABLE_REFUSALS)


def test_one_that_is_refused_is_neither_named_nor_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    name = next(effect.name for effect in EFFECTS if any(p.name in ERROR for p in effect.parameters()))
    posed = problem(n=1500, hidden={name: ERROR})
    (first,) = select(posed, COSTLY).accepted
    tried, of = [], CandidateTest.of

    def refusing(self: CandidateTest, one: CandidateFit) -> CandidateTrial:
        tried.append(one.evidence.name)
        return replace(of(self, one), refusal="for a reason") if len(tried) == 1 else of(self, one)

    monkeypatch.setattr(CandidateTest, "of", refusing)
    found = select(posed, COSTLY).accepted
    assert tried[0] in {first.name, *first.alternatives}
    assert found
    assert tried[0] not in {found[0].name, *found[0].alternatives}


def test_what_has_another_size_in_each_part_is_refused() -> None:
    """A current whose gain has another sign in the last quarter, beside a temperature that only rises."""
    given = recording(1500)
    assert given.current_A is not None
    gain = np.where(given.time_s < 0.75 * given.time_s[-1], 1.0, -1.0)
    posed = problem(replace(given, mag_nT=given.mag_nT + (gain * given.current_A[:, 0])[:, None] * [3.0, -2.0, 1.0]))
    accepted = select(posed, COSTLY).accepted
    assert "motor_current" not in [one.name for one in accepted if one.evidence.candidate.window is None]


@pytest.mark.parametrize(("gains", "kept"), [((100, 111), 0), ((100, 113), 1), ((2, 6), 0), ((2, 7), 1)])
def test_a_fuller_form_is_taken_from_the_start_where_it_gains_more_by_an_error_of_form(
    gains: tuple[float, float], kept: int
) -> None:
    assert best_of_each_name(["one", "one", "another"], np.array([*gains, 50.0]), STANDARD) == [kept, 2]


def test_the_strongest_of_a_first_look_are_fitted_and_the_others_keep_their_nats() -> None:
    """In flicker noise the motor that is there leads; what explains next to nothing of the gap comes last."""
    hidden = {"motor_current": {"gain_nT_A": [4.0, -3.0, 2.0]}, "flicker_noise": {"density_nT_sqrt_hz": [3.0] * 3}}
    start = Baseline.of(problem(n=2000, hidden=hidden))
    ranking = rank_candidates(start, propose_candidates(start.problem))
    fits, screened = screen(ranking, ColouredBaseline.of(start.problem, ()), start, start)
    assert fits[0].evidence.name == "motor_current"
    assert [fit.gain for fit in fits] == sorted((fit.gain for fit in fits), reverse=True)
    assert len(fits) == STANDARD.tried_coloured
    assert {fit.evidence.name for fit in fits} | {one.name for one, _ in screened} == {one.name for one in ranking}


def test_a_first_look_counts_what_is_gained_between_the_samples_of_a_row() -> None:
    """A tone faster than the rows, of which the means of the rows keep next to nothing."""
    tone = {"current_ripple": {"amplitude_nT_A": [3.0, -2.0, 2.5], "frequency_hz": 4.3}}
    start = Baseline.of(problem(n=3000, hidden=tone, policy=replace(STANDARD, most_rows=300)))
    (ripple,) = rank_candidates(start, {"current_ripple": propose_candidates(start.problem)["current_ripple"]})
    ((fit,), _) = screen([ripple], ColouredBaseline.of(start.problem, ()), start, start)
    assert fit.within > 0.9 * fit.gain > 100


def test_a_turn_of_the_field_by_what_is_left_out_is_no_loop() -> None:
    """An eddy current turns the field and has next to no part along it; a loop would have one."""
    quiet = recording(2000)
    eddies_s = 0.02 * np.array([[1.0, 0.3, -0.2], [0.0, 0.6, 0.2], [0.1, 0.0, 0.8]])
    posed = problem(replace(quiet, mag_nT=quiet.mag_nT + problem(quiet).state.field_rate_nT_s @ eddies_s.T))
    late = frozenset(effect.name for effect in EFFECTS if effect.traits.family)
    assert select(posed, late).accepted == ()


def _misturned(error_deg: Array) -> LinearProblem:
    """A recording whose attitude errs by a rotation vector (n, 3) of the Earth's axes."""
    given = recording(len(error_deg))
    true = Rotation.from_quat(given.att_q, scalar_first=True)
    logged = Rotation.from_rotvec(np.radians(error_deg)) * true
    return problem(replace(given, att_q=logged.as_quat(scalar_first=True)))


def test_a_field_that_does_what_an_attitude_that_grows_wrong_does_lists_the_attitude() -> None:
    ramp = np.linspace(0.0, 0.005, 2000)[:, None] * np.array([0.3, 0.5, 1.0])
    (one,) = select(_misturned(ramp)).accepted
    assert "attitude_misalignment" in (one.name, *one.alternatives)


@pytest.mark.parametrize("seed", [6, 7])
def test_the_mean_of_an_attitude_that_wanders_is_no_constant_turn_and_no_error_of_the_field(seed: int) -> None:
    kicks = np.random.default_rng(seed).normal(size=(2000, 3)) * np.sqrt(2 / 3000)
    wander = lfilter([1.0], [1.0, -np.exp(-1 / 3000)], kicks, axis=0)
    assert select(_misturned(0.05 * wander)).accepted == ()


@pytest.mark.parametrize("seed", [1, 3])
def test_a_burst_of_noise_is_no_effect_of_its_part(seed: int) -> None:
    """Two seconds of noise of twenty times the size, beside a walk: any effect in them gains hundreds of nats."""
    given, rng = recording(), np.random.default_rng(seed)
    begin_s, n = rng.uniform(50, 300), len(given)
    rng.normal(size=n)
    walk_nT = 0.05 * np.cumsum(rng.normal(size=(n, 3)), axis=0)
    acts = (given.time_s >= begin_s) & (given.time_s < begin_s + 2.0)
    loud_nT = 40.0 * np.stack(
        [np.convolve(rng.normal(size=n), np.ones(5) / 5**0.5, mode="same") for _ in range(3)], axis=1
    )
    assert select(problem(replace(given, mag_nT=given.mag_nT + walk_nT + loud_nT * acts[:, None]))).accepted == ()


@pytest.mark.parametrize("size_nT", [200.0, 1000.0])
def test_a_magnet_brought_near_within_a_second_is_no_louder_noise(size_nT: float) -> None:
    """Its ends, which are not sharp, leave more than the noise there; all else is a trace of what it takes."""
    given, rng = recording(), np.random.default_rng(3)
    time_s = given.time_s
    near = np.clip(time_s - 80.0, 0.0, 1.2) / 1.2 - np.clip(time_s - 140.0, 0.0, 1.2) / 1.2
    walk_nT = 0.05 * np.cumsum(rng.normal(size=(len(given), 3)), axis=0)
    (accepted,) = select(
        problem(replace(given, mag_nT=given.mag_nT + walk_nT + size_nT * np.outer(near, [0.6, -0.5, 0.62])))
    ).accepted
    assert accepted.name == "hard_iron"
    assert accepted.evidence.candidate.window == pytest.approx((80.6, 140.6), abs=1.0)
