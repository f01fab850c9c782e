"""Beside a rest of its own: what moved columns are, what is left of a rival, and what shows along the field."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.evidence import along_field as standing
from diagnosis.evidence.along_field import (
    explains_along_field,
    gain_along_field,
    residual_along_field,
    share_along_field,
)
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.candidate_test import ColouredBaseline, _to_and_fro, find_look_alikes, surrogate_columns
from diagnosis.evidence.held_out import search_price
from diagnosis.evidence.hypothesis import Hypothesis, in_sample_gains
from diagnosis.evidence.noise_model import NoiseModel
from diagnosis.library.candidates import Candidate
from diagnosis.policy import STANDARD
from diagnosis.problem.formulation import pose
from diagnosis.problem.known import Known, Level
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects.currents import MotorCurrent
from sim.effects.iron import HardIron, HardIronDrift
from tests.diagnosis.synthetic import FIELD_ENU_NT, STRENGTH_NT, problem, recording, without_attitude

HIDDEN = {MotorCurrent.name: {MotorCurrent.linear[0]: [1.0, -0.5, 0.75]}}


@pytest.fixture(scope="module")
def posed() -> LinearProblem:
    return problem(n=2000, hidden=HIDDEN)


@pytest.fixture(scope="module")
def coloured_baseline(posed: LinearProblem) -> ColouredBaseline:
    return ColouredBaseline.of(posed, [])


def test_what_only_rises_comes_back_and_does_not_jump() -> None:
    columns = np.arange(40.0)[:, None, None]
    moved = list(_to_and_fro(columns, 4))
    assert len(moved) == 4
    assert all(one.shape == columns.shape and np.abs(np.diff(one, axis=0)).max() <= 1 for one in moved)
    assert not any((one == columns).all() for one in moved)


def test_without_attitude_columns_are_moved_in_the_frame_of_the_sensor() -> None:
    """A constant of the sensor is one at any time, seen along the motion as it was."""
    posed = problem(without_attitude(recording(1000)))
    rows, one = ColouredBaseline.of(posed, []).rows, Candidate(HardIron)
    assert all(np.allclose(moved, rows.bin(one.columns(posed))) for moved in surrogate_columns(one, posed, rows))


def _evidence(tried: int) -> Any:
    return SimpleNamespace(candidate=SimpleNamespace(tried=tried), width=3)


def test_an_effect_gains_beside_a_rest_of_its_own_less_its_price(
    posed: LinearProblem, coloured_baseline: ColouredBaseline
) -> None:
    """Of which nothing is left for it moved in time."""
    rows, one = coloured_baseline.rows, Candidate(MotorCurrent)
    columns = rows.bin(one.columns(posed))
    stands = coloured_baseline.fit_candidate(_evidence(1), columns)
    assert stands.gain > STANDARD.coloured_nats
    in_sample = in_sample_gains(
        rows, coloured_baseline.accepted_columns, [columns, columns[:, :, :1]], coloured_baseline.hypothesis.noise_model
    )
    assert coloured_baseline.screening_gains([columns, columns[:, :, :1]]) == pytest.approx(
        in_sample - [columns.shape[2], 1]
    )
    assert coloured_baseline.fit_candidate(_evidence(1), columns, within=5.0).gain == pytest.approx(stands.gain + 5.0)
    priced = coloured_baseline.fit_candidate(_evidence(1000), columns).gain
    assert priced == pytest.approx(stands.gain - search_price(1000, 3, STANDARD))
    surrogate: Any = SimpleNamespace(evidence=SimpleNamespace(candidate=one), **_own(stands))
    assert coloured_baseline.surrogate_gains(surrogate).max() < 0.2 * stands.gain


@pytest.mark.parametrize("seed", [2, 4, 5])
def test_a_walk_is_no_drift_where_the_base_takes_up_a_part_of_it(seed: int) -> None:
    """Beside the rest that least squares of the base leave a drift gains 27 to 44 nats."""
    given = recording(3000)
    walk_nT = np.cumsum(np.random.default_rng(seed).normal(scale=0.1, size=given.mag_nT.shape), axis=0)
    walking = problem(replace(given, mag_nT=given.mag_nT + walk_nT))
    coloured_baseline = ColouredBaseline.of(walking, [])
    drift = coloured_baseline.fit_candidate(
        _evidence(1), coloured_baseline.rows.bin(Candidate(HardIronDrift).columns(walking))
    )
    assert drift.gain < STANDARD.coloured_nats / 2


def _own(one: Any) -> dict[str, Any]:
    return {"columns": one.columns, "hypothesis": one.hypothesis, "rows": one.rows, "gain": one.gain}


def test_a_slow_course_gains_nothing_beside_a_rest_that_is_as_slow() -> None:
    """Of what wanders by itself: the rest without the effect is the likelier of two."""
    given = problem(n=2000)
    walk = np.cumsum(np.random.default_rng(3).normal(size=(2000, 3)), axis=0)
    wandering = ColouredBaseline.of(replace(given, target=given.target + walk), [])
    slow = np.sin(np.linspace(0, 2, 2000))[:, None, None] * np.eye(3)
    assert wandering.fit_candidate(_evidence(1), wandering.rows.bin(slow)).gain < STANDARD.apart


def _walk(step: float, n: int = 2000) -> Array:
    return np.asarray(step * np.cumsum(np.random.default_rng(3).normal(size=(n, 3)), axis=0))


def test_what_a_rest_that_was_found_badly_lacks_is_no_gain_of_an_effect(coloured_baseline: ColouredBaseline) -> None:
    """A poorer hypothesis of five times the noise: beside the effect's own rest nothing is gained."""
    loud = replace(coloured_baseline.hypothesis.noise_model, white=25 * coloured_baseline.hypothesis.noise_model.white)
    badly = replace(
        coloured_baseline,
        hypothesis=Hypothesis.with_noise_model(coloured_baseline.rows, coloured_baseline.accepted_columns, loud),
    )
    nothing = np.sin(np.linspace(0, 7, 2000))[:, None, None] * np.eye(3)
    assert badly.fit_candidate(_evidence(1), nothing).gain < STANDARD.apart


@pytest.mark.parametrize("step", [0.0, 0.5])
def test_the_rest_beside_a_jump_is_the_one_that_is_there(step: float) -> None:
    """White noise, which the poorer hypothesis' rest does not lead to; a walk, which white noise does not lead to."""
    n, given = 2000, problem(n=2000)
    jump = (np.arange(n) > 1200)[:, None, None] * np.eye(3)
    coloured_baseline = ColouredBaseline.of(
        replace(given, target=given.target + _walk(step) + 10 * jump @ [1.0, 0.5, -1.0]), []
    )
    tau_s = 4 * n * coloured_baseline.rows.interval_s
    there = NoiseModel(
        np.array([tau_s]), np.ones(3), np.full((3, 1), step**2 * tau_s / (2 * coloured_baseline.rows.interval_s))
    )
    true = Hypothesis.with_noise_model(coloured_baseline.rows, coloured_baseline.columns_with(jump), there)
    assert (
        coloured_baseline.fit_candidate(_evidence(1), jump).hypothesis.log_likelihood
        > true.log_likelihood - STANDARD.apart
    )


def _event(at: int, half: int) -> Array:
    return np.asarray((np.abs(np.arange(2000) - at) < half)[:, None, None] * np.eye(3))


def test_an_event_stands_beside_a_wander_though_it_is_short() -> None:
    """Three samples of ten sigma in segments of twenty seconds: held out whole it would be foretold by nothing."""
    given, event = problem(n=2000), _event(900, 2)
    coloured_baseline = ColouredBaseline.of(
        replace(given, target=given.target + _walk(0.3) + 10 * event @ [1.0, 0.5, -1.0]), []
    )
    assert coloured_baseline.fit_candidate(_evidence(1), event).gain > STANDARD.coloured_nats


def test_a_second_event_gains_as_much_beside_the_first_as_without_it() -> None:
    """Each on folds that show it, with and without the effect."""
    given, first, second = problem(n=2000), _event(500, 2), _event(900, 5)
    one_nT = given.target + _walk(0.3) + 10 * second @ [1.0, 0.5, -1.0]
    alone = ColouredBaseline.of(replace(given, target=one_nT), [])
    both = ColouredBaseline.of(replace(given, target=one_nT + 10 * first @ [1.0, 0.5, -1.0]), [first])
    gains = [each.fit_candidate(_evidence(1), second).gain for each in (alone, both)]
    assert gains[1] == pytest.approx(gains[0], abs=STANDARD.apart)


def _levelled() -> LinearProblem:
    given = recording(2000)
    level = Level.of(problem(given).state.R_wb, FIELD_ENU_NT, STANDARD)
    return pose(without_attitude(given), Known(FIELD_ENU_NT, STRENGTH_NT, level=level))


def test_a_wander_of_the_axes_is_seen_as_a_constant_of_the_sensor_is() -> None:
    """By strength and dip over the noise of each."""
    posed = _levelled()
    posed = replace(posed, sigma_nT=posed.sigma_nT * [1.0, 3.0])
    constant = Candidate(HardIron).columns(posed) * posed.sigma_nT[0]
    assert ColouredBaseline.of(posed, []).rows.output_axes == pytest.approx(constant, abs=1e-2)


def test_where_strength_and_dip_are_compared_the_strength_is_along_the_field() -> None:
    left = np.random.default_rng(0).normal(size=(2000, 2)) * [1.0, 1e3]
    along = residual_along_field(SimpleNamespace(problem=_levelled(), residual=lambda: left))  # type: ignore[arg-type]
    assert along.var() == pytest.approx(1.0, abs=0.5)


def test_a_rival_keeps_what_is_its_own(posed: LinearProblem, coloured_baseline: ColouredBaseline) -> None:
    columns = coloured_baseline.rows.bin(Candidate(MotorCurrent).columns(posed))
    best = coloured_baseline.fit_candidate(_evidence(1), columns)
    assert coloured_baseline.remaining_share(best, best) == pytest.approx(0.0, abs=0.02)
    t = np.linspace(0, 40, len(columns))[:, None, None]
    other = np.sin(t) * np.eye(3)
    both = ColouredBaseline.in_rows(
        posed,
        replace(coloured_baseline.rows, target=coloured_baseline.rows.target + 2 * other.sum(axis=2)),
        coloured_baseline.accepted_columns,
    )
    one, rival = (both.fit_candidate(_evidence(1), some) for some in (columns, other))
    assert both.remaining_share(rival, one) == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize(("gained", "tried", "holds"), [(8.0, 1, True), (6.0, 1, False), (8.0, 1000, False)])
def test_what_shows_along_the_field_is_beyond_chance_and_the_price_of_a_search(
    gained: float, tried: int, holds: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three columns gain 1.5 nats by chance; ln(100) are needed."""
    before, after = (
        SimpleNamespace(sums=SimpleNamespace(width=width), problem=SimpleNamespace(policy=STANDARD)) for width in (2, 5)
    )
    monkeypatch.setattr(standing, "gain_along_field", lambda before, after, k: gained if k == 3 else 0.0)
    assert explains_along_field(before, after, tried) is holds  # type: ignore[arg-type]


@pytest.mark.parametrize(("left", "nats"), [(1.0, 40.0), (2.0, 6.25), (0.5, 43.75)])
def test_nats_along_the_field_are_over_what_is_left(left: float, nats: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of ten means of three sigma."""
    monkeypatch.setattr(standing, "residual_along_field", lambda baseline: baseline * np.ones(10))
    assert gain_along_field(3.0, left) == pytest.approx(nats)  # type: ignore[arg-type]


def test_what_is_slow_gains_along_the_field_as_the_slow_noise_has_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten means of one sigma with one sign: five of two are twice as loud, where so many are enough."""
    monkeypatch.setattr(standing, "residual_along_field", lambda baseline: baseline * np.ones(10))
    gained = [gain_along_field(3.0, 1.0, least) for least in (10, 6, 5, 3)]  # type: ignore[arg-type]
    np.testing.assert_allclose(gained, [40.0, 40.0, 20.0, 20.0])
    monkeypatch.setattr(standing, "residual_along_field", lambda baseline: baseline * (-1.0) ** np.arange(10))
    assert gain_along_field(3.0, 1.0, 2) == pytest.approx(40.0)  # type: ignore[arg-type]


def test_along_the_field_white_noise_is_white_and_an_error_of_matrix_or_attitude_is_nothing() -> None:
    posed = problem(n=4000)
    usable = (np.arange(4000) % 7 > 2).astype(float)

    def along(left: Array, posed: LinearProblem = posed) -> Array:
        return residual_along_field(SimpleNamespace(problem=posed, residual=lambda: left))  # type: ignore[arg-type]

    field = posed.state.field_nT / posed.sigma_nT
    matrix = np.array([[0.01, 0.02, 0.0], [0.0, -0.01, 0.0], [0.0, 0.03, 0.02]])
    turned = np.cross(posed.state.field_nT, [1e-3, 2e-3, -1e-3] * np.sin(posed.state.time_s / 9)[:, None])
    white = along(np.random.default_rng(0).normal(size=(4000, 3)))
    assert len(white) == 80  # of five seconds each
    assert white.var() == pytest.approx(1.0, abs=0.4)
    assert np.abs(along(posed.state.field_nT @ matrix / posed.sigma_nT)).max() < 0.01 * np.abs(field @ matrix).max()
    off = (posed.state.field_nT @ matrix / posed.sigma_nT) * usable[:, None]
    assert np.abs(along(off, replace(posed, usable=usable))).max() < 0.01 * np.abs(off).max()
    assert np.abs(along(turned / posed.sigma_nT)).max() < 0.3 * np.abs(turned / posed.sigma_nT).max()


@pytest.mark.parametrize(
    ("gain", "share", "left", "near"),
    [
        (97.0, 0.01, 0.1, True),
        (94.0, 0.01, 0.1, False),
        (91.0, 0.1, 0.1, True),
        (89.0, 0.1, 0.1, False),
        (97.0, 0.1, 0.6, False),
    ],
)
def test_look_alikes_are_near_and_of_no_use_beside_the_best(gain: float, share: float, left: float, near: bool) -> None:
    """Within five nats or a share of a hundred."""
    best, other = SimpleNamespace(gain=100.0), SimpleNamespace(gain=gain)
    coloured_baseline: Any = SimpleNamespace(remaining_share=lambda *_: left, rows=SimpleNamespace(policy=STANDARD))
    assert bool(find_look_alikes(best, [other], coloured_baseline, 5.0, share)) is near  # type: ignore[arg-type,list-item]


@pytest.mark.parametrize(("before", "after", "share"), [(5.0, 2.0, 0.75), (5.0, 1.0, 1.0), (0.9, 0.8, 0.0)])
def test_the_share_along_the_field_is_of_what_exceeds_white_noise(
    before: float, after: float, share: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of mean squares before and after, in the noise's units."""
    monkeypatch.setattr(standing, "residual_along_field", lambda square: np.full(9, np.sqrt(square)))
    either: Any = (before, after)
    assert share_along_field(*either) == pytest.approx(share)


def test_along_the_field_a_short_recording_has_fewer_means_than_columns() -> None:
    """Of 20 s there are four means of 5 s, and nine columns may explain them: no variance is left to raise a chance."""
    short = Baseline.of(problem(n=200, hidden=HIDDEN))
    columns = np.concatenate(
        [short.problem.earth_axes() * short.problem.state.time_s[:, None, None] ** k for k in range(3)], axis=2
    )
    assert not explains_along_field(short, short.with_columns(columns))
