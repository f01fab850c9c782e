"""Hypotheses beside a rest with its own colour: against dense algebra, and what stands beside a wander."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.decision.selection import select
from diagnosis.evidence.along_field import explains_along_field, gain_along_field
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.binned_rows import BinnedRows
from diagnosis.evidence.candidate_test import ColouredBaseline, surrogate_columns
from diagnosis.evidence.hypothesis import Hypothesis, in_sample_gains, white_noise_model
from diagnosis.evidence.noise_model import NoiseModel
from diagnosis.library.candidates import Candidate, propose_candidates
from diagnosis.policy import STANDARD, Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.strength import dip_columns
from recordings.channels import TEMPERATURE
from sim.effects import EFFECTS
from sim.effects.channels import ChannelEffect
from tests.diagnosis.evidence.test_noise_model import covariance
from tests.diagnosis.synthetic import COSTLY, problem, recording, without_attitude
from tests.nightly import first_daily

DRIVEN = next(effect for effect in EFFECTS if effect.with_role("motor") and not effect.search_role())
WARM = next(effect for effect in EFFECTS if any(p.unit == "nT/K" for p in effect.parameters()))
HIDDEN = {DRIVEN.name: {DRIVEN.linear[0]: [2.0, -1.0, 4.0]}}


def _rows(n: int = 120, q: int = 2, p: int = 2) -> tuple[BinnedRows, np.ndarray]:  # type: ignore[type-arg]
    rng = np.random.default_rng(5)
    time_s = np.arange(float(n))
    base, target, columns = rng.normal(size=(n, p)), rng.normal(size=(n, q)), rng.normal(size=(n, q, 3))
    return BinnedRows.of(time_s, np.ones(n), base, target, STANDARD), columns


def test_coefficients_are_those_of_generalised_least_squares() -> None:
    rows, columns = _rows()
    noise_model = NoiseModel(np.array([5.0, 60.0]), np.array([1.0, 0.5]), np.array([[0.7, 2.0], [0.2, 4.0]]))
    found = Hypothesis.with_noise_model(rows, columns, noise_model)
    N, g, ln = np.zeros((7, 7)), np.zeros(7), 0.0
    for a in range(2):
        C = covariance(noise_model, rows.row_start_s, a)
        X = np.zeros((len(rows.row_start_s), 7))
        X[:, 2 * a : 2 * a + 2], X[:, 4:] = rows.base[:, a], columns[:, a]
        N, g = N + X.T @ np.linalg.solve(C, X), g + X.T @ np.linalg.solve(C, rows.target[:, a])
        ln += np.linalg.slogdet(C)[1] + rows.target[:, a] @ np.linalg.solve(C, rows.target[:, a])
    solution = np.linalg.solve(N, g)
    np.testing.assert_allclose(np.concatenate([found.beta.ravel(), found.c]), solution, rtol=1e-8)
    assert found.log_likelihood == pytest.approx(-(ln - g @ solution) / 2, rel=1e-10)
    assert found.held_out_log_likelihood < found.log_likelihood
    assert found.residual(rows, columns).shape == rows.target.shape


def test_outputs_with_a_base_in_common_share_its_coefficients() -> None:
    rng = np.random.default_rng(7)
    n, q, p = 90, 2, 4
    base, target, columns = rng.normal(size=(n, q, p)), rng.normal(size=(n, q)), rng.normal(size=(n, q, 3))
    rows = BinnedRows.of(np.arange(float(n)), np.ones(n), base, target, STANDARD)
    noise_model = NoiseModel(np.array([5.0, 60.0]), np.array([1.0, 0.5]), np.array([[0.7, 2.0], [0.2, 4.0]]))
    found = Hypothesis.with_noise_model(rows, columns, noise_model)
    N, g = np.zeros((7, 7)), np.zeros(7)
    for a in range(q):
        X, C = np.concatenate([base[:, a], columns[:, a]], axis=1), covariance(noise_model, rows.row_start_s, a)
        N, g = N + X.T @ np.linalg.solve(C, X), g + X.T @ np.linalg.solve(C, target[:, a])
    solution = np.linalg.solve(N, g)
    np.testing.assert_allclose(np.concatenate([found.beta.ravel(), found.c]), solution, rtol=1e-8)
    both = np.concatenate([base, columns], axis=2)
    np.testing.assert_allclose(found.residual(rows, columns), target - both @ solution, rtol=1e-8, atol=1e-10)
    (nats,) = in_sample_gains(rows, columns[:, :, :0], [columns], noise_model)
    without = Hypothesis.with_noise_model(rows, columns[:, :, :0], noise_model)
    assert nats == pytest.approx(found.log_likelihood - without.log_likelihood, rel=1e-9)


def test_rows_keep_the_variance_of_white_noise_and_the_sum_of_what_is_usable() -> None:
    rng = np.random.default_rng(6)
    usable = (rng.random(30_000) > 0.3).astype(float)
    y = rng.normal(size=(30_000, 1)) * usable[:, None]
    rows = BinnedRows.of(np.arange(30_000) / 10, usable, np.ones((30_000, 1)), y, replace(STANDARD, most_rows=4000))
    assert len(rows.target) <= 4000
    assert rows.count.sum() == usable.sum()
    assert rows.target[rows.count > 0].var() == pytest.approx(1.0, abs=0.08)
    assert set(np.unique(rows.fold)) == set(range(STANDARD.folds))


def _wandering(seed: int, hidden: dict[str, object] | None, step_nT: float = 0.6) -> LinearProblem:
    given = recording(seed=seed, hidden=hidden)
    walk = np.cumsum(step_nT * np.random.default_rng(seed).normal(size=(len(given), 3)), axis=0)
    return problem(replace(given, mag_nT=given.mag_nT + walk))


@pytest.mark.parametrize("seed", first_daily(range(3)))
def test_beside_a_wander_of_its_size_an_effect_is_found(seed: int) -> None:
    found = select(_wandering(seed, HIDDEN, step_nT=0.1), COSTLY)
    assert found.accepted[0].name == DRIVEN.name
    assert not found.after.clean


@pytest.mark.parametrize("seed", first_daily(range(10, 14)))
def test_in_a_wander_alone_nothing_is_found(seed: int) -> None:
    found = select(_wandering(seed, None))
    assert not found.before.clean
    assert found.accepted == ()


def test_a_candidate_that_explains_little_beside_a_coloured_rest_is_no_name() -> None:
    posed = _wandering(0, HIDDEN, step_nT=0.1)
    strict = replace(posed, policy=Policy(trace=0.9))
    assert select(strict).accepted == ()


def test_an_error_of_the_attitude_gains_nothing_along_the_field() -> None:
    given = recording()
    columns = propose_candidates(problem(given))["diurnal_drift"][0].columns(problem(given))
    course = np.sin(0.011 * given.time_s)[:, None] * np.array([8.0, 25.0, -60.0])
    sensed = given.mag_nT + np.einsum("nji,nj->ni", problem(given).state.R_wb, course)
    turned = np.cross(np.sin(0.011 * given.time_s)[:, None] * [2e-3, -1e-3, 1e-3], problem(given).state.field_nT)
    baselines = [Baseline.of(problem(replace(given, mag_nT=mag))) for mag in (sensed, given.mag_nT + turned)]
    in_sample_gains = [explains_along_field(baseline, baseline.with_columns(columns)) for baseline in baselines]
    assert in_sample_gains == [True, False]


def test_from_white_alone_a_slow_course_is_not_swallowed() -> None:
    """A drift is a course that a slow rest can follow: of two starts the likelier tells."""
    rng = np.random.default_rng(7)
    time_s = np.arange(3000) / 10
    y = 0.01 * time_s[:, None] + rng.normal(size=(3000, 1))
    rows = BinnedRows.of(time_s, np.ones(3000), np.ones((3000, 1)), y, STANDARD)
    drift = rows.bin((time_s - time_s.mean())[:, None, None])
    poorer = Hypothesis.of(rows, drift[:, :, :0], (white_noise_model(1),))
    richer = Hypothesis.of(rows, drift, (poorer.noise_model, white_noise_model(1)))
    assert richer.held_out_log_likelihood - poorer.held_out_log_likelihood > 10


def test_what_surrogates_gain_as_well_is_no_effect(monkeypatch: pytest.MonkeyPatch) -> None:
    """By their greatest gain, and by their mean, which deflates the evidence."""
    posed = _wandering(0, HIDDEN, step_nT=0.1)
    for by_chance in (np.r_[np.zeros(15), 1e6], np.full(16, 300.0)):
        with monkeypatch.context() as patch:
            patch.setattr(ColouredBaseline, "surrogate_gains", lambda self, one, by_chance=by_chance: by_chance)
            assert select(posed).accepted == ()


def test_a_course_that_only_rises_does_not_jump_when_it_is_moved() -> None:
    """Rolled in time a ramp jumps, as no slow noise does: chance would seem smaller than it is."""
    posed = problem(recording(2000))
    rows = ColouredBaseline.of(posed, ()).rows
    rising = replace(posed, state=replace(posed.state, channels={TEMPERATURE: np.linspace(10.0, 12.0, 2000)}))
    candidate = Candidate(WARM)
    as_it_is = np.abs(np.diff(candidate.columns(rising), axis=0)).max()
    assert all(
        np.abs(np.diff(one, axis=0)).max() < 1.01 * as_it_is for one in surrogate_columns(candidate, rising, rows)
    )


def test_what_adds_along_the_field_what_is_not_there_is_refused() -> None:
    """Beside an attitude that wanders columns without a cause find something, on all axes alike."""
    given, rng = recording(2000), np.random.default_rng(4)
    turned = np.cross(np.cumsum(rng.normal(scale=3e-5, size=(2000, 3)), axis=0), problem(given).state.field_nT)
    posed = problem(replace(given, mag_nT=given.mag_nT + turned))
    baseline = Baseline.of(posed)
    course = np.cumsum(rng.normal(size=(2000, 1)), axis=0)
    columns = posed.whitened(course[:, :, None] * np.eye(3), ChannelEffect)
    assert gain_along_field(baseline, baseline.with_columns(columns)) < -posed.policy.apart
    true = problem(replace(given, mag_nT=given.mag_nT + turned + 0.5 * course))
    assert gain_along_field(Baseline.of(true), Baseline.of(true).with_columns(columns)) > posed.policy.apart


def test_folds_show_an_event_and_leave_the_others_as_they_were() -> None:
    """An event of some seconds acts in every fold; a course over the whole run keeps the policy's segments."""
    time_s = np.arange(6000) / 10
    rows = BinnedRows.of(time_s, np.ones(6000), np.ones((6000, 1)), np.zeros((6000, 1)), STANDARD)
    event, drift = (rows.bin(v[:, None, None]) for v in (np.exp(-(((time_s - 300) / 4) ** 2)), time_s))
    assert rows.refine_folds(drift) is rows
    short = rows.refine_folds(event)
    power = np.bincount(short.fold, (event**2).sum(axis=(1, 2)))
    assert (power > 0.02 * power.sum()).all()
    both = rows.refine_folds(np.concatenate([drift, event, 0 * event], axis=2))
    assert both.segment_s == short.segment_s


def test_a_column_that_others_make_gains_nothing_whatever_its_unit() -> None:
    """Once it is in, in other units, rounding is all that is left of it: no gain, and no overflow."""
    rng = np.random.default_rng(8)
    time_s = np.arange(2000) / 10
    rows = BinnedRows.of(time_s, np.ones(2000), np.ones((2000, 1)), rng.normal(size=(2000, 3)), STANDARD)
    columns = rng.normal(size=(2000, 3, 2))
    accepted_columns = np.concatenate([columns * [1e-5, 1e6], rng.normal(size=(2000, 3, 1))], axis=2)
    again, other = in_sample_gains(
        rows,
        accepted_columns,
        [columns @ [[1.0, 2.0], [3.0, 4.0]], rng.normal(size=(2000, 3, 2))],
        white_noise_model(3),
    )
    assert again == pytest.approx(0.0, abs=1e-6)
    assert 0 < other < 20


@pytest.mark.parametrize("seen", ["vector", "strength"])
def test_what_is_moved_in_time_is_seen_along_the_motion_as_it_was(seen: str) -> None:
    """To and fro, begun at odd parts of the run: the cause moves, the direction does not."""
    posed = problem(recording(2000) if seen == "vector" else without_attitude(recording(2000)))
    candidate = Candidate(DRIVEN)
    rows = ColouredBaseline.of(posed, ()).rows
    moved = surrogate_columns(candidate, posed, rows)
    assert len(moved) == STANDARD.surrogates
    late = {name: np.r_[x[::-1], x][625:2625] for name, x in posed.state.channels.items()}
    gone = replace(posed, state=replace(posed.state, channels=late))
    assert np.allclose(moved[2], rows.bin(candidate.columns(gone)), atol=1e-9)
    assert not np.allclose(moved[2], rows.bin(candidate.columns(posed)), atol=1e-3)


@pytest.mark.parametrize("seed", [0, 2, 6])
def test_axes_that_walk_are_as_likely_by_the_rest_that_is_found(seed: int) -> None:
    """The fitted iron takes up much of such a walk: what it leaves has the spectrum of a faster wander."""
    rng, n, step = np.random.default_rng(seed), 3000, 0.03
    i = np.arange(float(n))
    yaw, dip = 4e-3 * i + 0.5 * np.sin(0.01 * i), 1.1 + 0.3 * np.sin(0.023 * i)
    level, up = np.column_stack([np.cos(yaw), np.sin(yaw), 0 * i]), np.array([0.0, 0.0, 1.0])
    c, s = np.cos(dip)[:, None], np.sin(dip)[:, None]
    output_axes = np.stack([c * level + s * up, c * up - s * level], axis=1)
    walk = np.cumsum(step * rng.normal(size=(n, 3)), axis=0)
    seen = np.einsum("nqi,ni->nq", output_axes, walk) + rng.normal(size=(n, 2))
    rows, none = (
        BinnedRows.of(i, np.ones(n), dip_columns(output_axes), seen, STANDARD, output_axes),
        np.zeros((n, 2, 0)),
    )
    true = NoiseModel(np.array([1e5]), np.ones(2), np.zeros((2, 1)), np.array([step**2 * 1e5 / 2]), output_axes)
    found = Hypothesis.of(rows, none, (white_noise_model(2),))
    assert found.log_likelihood > Hypothesis.with_noise_model(rows, none, true).log_likelihood - 3
