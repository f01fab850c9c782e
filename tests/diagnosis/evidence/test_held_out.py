"""Evidence is the log-likelihood ratio on held-out data, by dense least squares, less what a search gains by chance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import judge_candidate, judge_settings, rank_candidates, search_price
from diagnosis.library.candidates import Candidate, propose_candidates
from diagnosis.policy import STANDARD, Policy
from diagnosis.problem.blocks import held_out_folds
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.effects.base import Effect
from tests.diagnosis.synthetic import problem, recording

DRIVEN = next(effect for effect in EFFECTS if effect.with_role("motor") and not effect.search_role())
HIDDEN = {DRIVEN.name: {DRIVEN.linear[0]: [1.0, -0.5, 2.0]}}
MOTOR = DRIVEN.with_role("motor")
CANDIDATE = Candidate(DRIVEN, ((MOTOR or "", 0),))


def _dense_gain(baseline: Baseline, columns: Array) -> float:
    """Nats of the held-out log-likelihood ratio, by least squares on stacked rows."""
    posed, (n, q, k) = baseline.problem, columns.shape
    base = np.kron(posed.base[:, None, :], np.eye(q)).reshape(n * q, -1)
    both = np.concatenate([base, columns.reshape(n * q, k)], axis=1)
    y, total = posed.target.ravel(), 0.0
    used = baseline.cut.m * baseline.cut.length
    for held in held_out_folds(posed.policy):
        rows = np.repeat(np.repeat(held[baseline.cut.fold], baseline.cut.length), q)
        rows = np.concatenate([rows, np.zeros((n - used) * q, bool)])
        train = ~rows & (np.arange(n * q) < used * q)
        for design, sign in ((base, 1), (both, -1)):
            c = np.linalg.lstsq(design[train], y[train], rcond=None)[0]
            total += sign * float(((y - design @ c)[rows] ** 2).sum()) / 2
    return total / posed.policy.held_segments


def test_the_gain_is_that_of_dense_least_squares() -> None:
    baseline = Baseline.of(problem(hidden=HIDDEN))
    found = judge_settings(baseline, [CANDIDATE])
    assert found is not None
    dense = _dense_gain(baseline, CANDIDATE.columns(baseline.problem))
    fitted = float(baseline.sums.count.sum()) * 3 * found.strength**2 / 2
    assert found.gain == pytest.approx(min(dense, fitted), rel=1e-6)
    assert found.nats == pytest.approx(found.gain / found.V)
    assert baseline.evidence_of(CANDIDATE.columns(baseline.problem)) == pytest.approx(dense / found.V)


def test_a_number_that_may_have_one_value_alone_keeps_it() -> None:
    lagged = next(effect for effect in EFFECTS if "rate" in effect.needs and len(effect.search) == 1)
    ((name, listed),) = lagged.search.items()
    posed = problem(n=2000, hidden={lagged.name: lagged.example | {name: listed[-1]}})
    each = propose_candidates(posed)[lagged.name]
    alone, free = (judge_candidate(Baseline.of(posed), members) for members in (each[:1], each))
    assert alone is not None
    assert free is not None
    assert dict(alone.candidate.nonlinear)[name] == listed[0]
    assert dict(free.candidate.nonlinear)[name] == pytest.approx(listed[-1], rel=0.05)


def test_coefficients_and_strength_are_those_that_were_hidden() -> None:
    posed = problem(hidden=HIDDEN, noise_nT=0.05)
    found = judge_settings(Baseline.of(posed), [CANDIDATE])
    assert found is not None
    assert found.candidate.to_effect(found.coefficients).coefficients()[:3] == pytest.approx([1.0, -0.5, 2.0], abs=0.02)
    part = CANDIDATE.columns(posed) @ found.coefficients
    left = part - posed.base @ np.linalg.lstsq(posed.base, part, rcond=None)[0]
    assert found.strength == pytest.approx(np.sqrt((left**2).mean()), rel=0.01)
    assert found.survival == pytest.approx(np.linalg.norm(left) / np.linalg.norm(part), rel=0.01)


def test_white_noise_pays_for_every_column() -> None:
    """A column that explains nothing costs 5/6 nats in the mean: on two fifths held out k/3, five times, over two."""
    baseline, rng = Baseline.of(problem()), np.random.default_rng(0)
    nats = [baseline.evidence_of(rng.normal(size=(4000, 3, 3))) for _ in range(60)]
    assert np.mean(nats) == pytest.approx(-3 * 5 / 6, abs=0.8)


def test_the_price_of_a_search_is_what_the_best_of_many_gains_by_chance() -> None:
    """Median of the greatest of n chi squared over two, drawn."""
    rng, n = np.random.default_rng(0), 500
    for k in (1, 3, 6):
        best = rng.chisquare(k, (400, n)).max(axis=1) / 2
        assert search_price(n, k, STANDARD) == pytest.approx(float(np.median(best)), abs=0.7)
    assert search_price(50, 3, STANDARD) == 0.0 < search_price(51, 3, STANDARD)


def test_colour_deflates_evidence() -> None:
    given = recording(hidden=HIDDEN)
    slow = np.cumsum(np.random.default_rng(1).normal(size=(len(given), 3)), axis=0) * 0.1
    plain, coloured = (Baseline.of(problem(r)) for r in (given, replace(given, mag_nT=given.mag_nT + slow)))
    first, second = judge_settings(plain, [CANDIDATE]), judge_settings(coloured, [CANDIDATE])
    assert first is not None
    assert second is not None
    assert first.V < 1.5
    assert second.V > 3
    assert second.nats < first.nats / 2


def test_the_hidden_effect_is_first_and_accepted_and_a_rival_is_behind_it() -> None:
    posed = problem(hidden=HIDDEN)
    order = rank_candidates(Baseline.of(posed), propose_candidates(posed))
    assert order[0].name == DRIVEN.name
    assert order[0].nats > STANDARD.accepted(len(EFFECTS))
    assert [e.gain for e in order] == sorted((e.gain for e in order), reverse=True)
    assert order[-1].is_behind(order[0], STANDARD)
    rival = replace(order[0], gain=order[0].gain - 3 * order[0].V)
    assert not rival.is_behind(order[0], STANDARD)
    assert rival.is_behind(order[0], Policy(alpha=0.1))


def test_beside_the_effect_itself_it_explains_no_more() -> None:
    posed = problem(hidden=HIDDEN)
    baseline = Baseline.of(posed).with_columns(CANDIDATE.columns(posed))
    again = judge_settings(baseline, [CANDIDATE])
    assert again is None or again.nats < STANDARD.apart


def test_columns_that_are_nothing_are_no_candidate() -> None:
    still = replace(recording(), current_A=np.zeros((4000, 2)))
    assert judge_candidate(Baseline.of(problem(still)), [CANDIDATE]) is None


LATE = [e for e in EFFECTS if e.search and not (e.linear or e.tangents or e.stochastic)]


@pytest.mark.parametrize("effect", LATE)
@pytest.mark.parametrize(("which", "part"), [(-1, 1e-4), (0, 0.1)])
def test_an_effect_without_coefficients_is_moved_to_its_own_size(effect: type[Effect], which: int, part: float) -> None:
    """Far below a sample's interval half of a delay is half of the effect: a small part is one at a smaller delay."""
    ((name, listed),) = effect.search.items()
    posed = problem(noise_nT=1e-3)
    members = [Candidate(effect, ((name, value),)) for value in listed]
    one = sorted(members, key=lambda one: float(np.linalg.norm(one.columns(posed))))[which]
    found = judge_candidate(Baseline.of(replace(posed, target=part * one.columns(posed)[:, :, 0])), [one])
    assert found is not None
    assert found.coefficients[0] == pytest.approx(1.0, rel=0.1)


@pytest.mark.parametrize("effect", LATE)
@pytest.mark.parametrize("drift_sigma", [30.0, 90.0])
def test_it_has_its_own_size_beside_a_drift_that_takes_its_evidence(effect: type[Effect], drift_sigma: float) -> None:
    ((name, listed),) = effect.search.items()
    posed = problem(noise_nT=1e-3)
    members = [Candidate(effect, ((name, value),)) for value in listed]
    least = min((one.columns(posed)[:, :, 0] for one in members), key=lambda late: float((late**2).sum()))
    late = 3 * least / np.sqrt((least**2).mean()) + np.random.default_rng(0).normal(size=least.shape)
    drift = drift_sigma * np.linspace(-1.0, 1.0, len(late))[:, None]
    found = judge_candidate(Baseline.of(replace(posed, target=late + drift)), members)
    assert found is not None
    assert found.nats < STANDARD.apart
    assert found.coefficients[0] == pytest.approx(1.0, rel=0.1)


def test_on_all_data_columns_of_noise_are_not_worth_their_number() -> None:
    """They gain ``k / 2`` in the mean, and cost ``k / 2 ln m``."""
    posed = problem()
    baseline, rng = Baseline.of(posed), np.random.default_rng(0)
    k, m = 4, len(baseline.sums.count)
    nats = [baseline.evidence_on_all(rng.normal(size=(*posed.target.shape, k))) for _ in range(20)]
    assert np.mean(nats) == pytest.approx(k / 2 * (1 - np.log(m)), abs=1.5)
