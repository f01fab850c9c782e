"""The rivals that [Li2017] cites: what each finds without noise, what it cannot, and their rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from papers.base import PaperRow
from papers.li2017.rival_rows import RivalErrors, rival_rows, rival_trial
from papers.li2017.rivals import RIVALS, TurnedField, truncated_state, truncated_total
from papers.li2017.trials import TRUE_STATE, TRUNCATED, Survey, filter_trial, simulated

FIELD_NT = np.array([1000.0, 20_000.0, -40_000.0])
IRON_NT = np.array([300.0, -500.0, 800.0])
SYMMETRIC = np.array([[1.1, 0.02, -0.03], [0.02, 0.95, 0.04], [-0.03, 0.04, 1.0]])
TURN = Rotation.from_rotvec([0.02, -0.01, 0.03]).as_matrix()


def seen(S: np.ndarray, level: bool = False) -> tuple[TurnedField, np.ndarray]:
    """What a sensor m = S h + b sees at random attitudes, or level on all headings, and the true field in its axes."""
    heading = Rotation.from_euler("z", np.linspace(0.0, 2 * np.pi, 2000)[:, None])
    turns = heading if level else Rotation.random(2000, rng=np.random.default_rng(3))
    R_wb = turns.as_matrix()
    field_nT = np.einsum("nij,i->nj", R_wb, FIELD_NT)
    return TurnedField(field_nT @ S.T + IRON_NT, R_wb[:, 2], FIELD_NT), field_nT


@pytest.mark.parametrize("name", RIVALS)
def test_every_rival_takes_symmetric_iron_off(name: str) -> None:
    given, field_nT = seen(SYMMETRIC)
    close = 5.0 if name == "functional-link network" else 1e-4  # a network is trained, not solved
    assert np.abs(RIVALS[name](given).apply(given.measured_nT) - field_nT).max() < close


def test_the_field_s_strength_leaves_a_turn_and_the_vertical_does_not() -> None:
    given, field_nT = seen(SYMMETRIC @ TURN)
    error = {name: rival(given).apply(given.measured_nT) - field_nT for name, rival in RIVALS.items()}
    assert np.abs(error["dot product"]).max() < 1e-4
    left = error["truncated total least squares"]
    # TURN turns by 0.037 rad, so a field of strength F is off by at most 0.037 F, and by a good part of it somewhere
    assert 0.02 < np.linalg.norm(left, axis=1).max() / np.linalg.norm(FIELD_NT) < 0.038
    strength = np.linalg.norm(field_nT + left, axis=1) - np.linalg.norm(FIELD_NT)
    assert np.abs(strength).max() < 1e-3


def test_a_level_turn_fixes_the_strength_and_leaves_the_rest_near_a_perfect_sensor() -> None:
    given, _ = seen(np.eye(3), level=True)
    found = {name: RIVALS[name](given) for name in ("truncated total least squares", "dot product")}
    for correction in found.values():
        assert np.linalg.norm(correction.matrix - np.eye(3)) < 0.1
    quadric = found["truncated total least squares"]
    strength = np.linalg.norm(quadric.apply(given.measured_nT), axis=1)
    np.testing.assert_allclose(strength, given.strength_nT, atol=1.0)
    # the vertical's product sees z alone there: nothing of the offset in x and y
    assert np.abs(found["dot product"].offset_nT[:2]).max() < 20.0


def test_truncated_total_least_squares_is_the_line_of_least_distance() -> None:
    """One unknown: the slope of the first principal axis of the points; a column without effect stays zero."""
    rng = np.random.default_rng(4)
    x = rng.uniform(-1.0, 1.0, 400)
    points = np.column_stack((x, 2.0 * x)) + 0.05 * rng.standard_normal((400, 2))
    size, axes = np.linalg.eigh(points.T @ points)
    slope = axes[1, 1] / axes[0, 1]
    assert size[1] > size[0]
    assert truncated_total(points[:, :1], points[:, 1]) == pytest.approx([slope])
    rows = np.column_stack((points[:, 0], np.full(400, 1e-9)))
    np.testing.assert_allclose(truncated_total(rows, points[:, 1]), [slope, 0.0], atol=1e-6)


def test_all_parameters_of_equation_1_are_found_without_noise() -> None:
    data = simulated(0, 3000)
    exact = replace(data, difference_nT=data.observation() @ TRUE_STATE)
    np.testing.assert_allclose(truncated_state(exact), TRUE_STATE, rtol=1e-6)


def test_a_network_of_another_seed_ends_near_by() -> None:
    given, _ = seen(SYMMETRIC)
    one, other = (RIVALS["functional-link network"](replace(given, seed=seed)) for seed in (0, 1))
    assert not np.array_equal(one.offset_nT, other.offset_nT)
    np.testing.assert_allclose(one.offset_nT, other.offset_nT, atol=5.0)


@pytest.fixture(scope="module")
def found() -> list[RivalErrors]:
    return [rival_trial(seed) for seed in (0, 1)]


def rows_of(found: list[RivalErrors]) -> list[PaperRow]:
    surveys = [Survey(np.ones(3), {name: np.arange(3.0) for name in (*RIVALS, TRUNCATED, "kalman_fuzzy")}, {})]
    return rival_rows(found, [filter_trial(0)], surveys)


def test_rows_say_what_the_total_field_leaves_open(found: list[RivalErrors]) -> None:
    rows = rows_of(found)
    verdicts = [row.verdict for row in rows]
    assert verdicts == ["holds", "holds", "does not hold", "holds", "not comparable", "not comparable"]
    assert {bool(row.judged.tolerance and row.judged.reason) for row in rows} == {True}


def test_components_as_good_as_the_strength_refute_the_claim(found: list[RivalErrors]) -> None:
    good = {key: 0.0 * value for key, value in found[0].component_nT.items()}
    assert rows_of([replace(found[0], component_nT=good)])[0].verdict == "does not hold"
