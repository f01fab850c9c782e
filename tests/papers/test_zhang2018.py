"""The reproduction of [Zhang2018]: its spiral, its bounds, its printed table and its rows."""

from __future__ import annotations

import numpy as np
import pytest

from calib.models.quadric import design, shape_matrix
from papers.zhang2018 import trials as zhang2018_trials
from papers.zhang2018.ellipsoid_rows import quadric_row
from papers.zhang2018.least_squares import METHODS as LEAST_SQUARES
from papers.zhang2018.least_squares import least_squares_trial
from papers.zhang2018.paper import Zhang2018
from papers.zhang2018.printed_table import AFTER_NT, PRINTED_F_NT, TOTAL_NT
from papers.zhang2018.trials import (
    DRIFT_NT_H,
    LONGER,
    MAIN,
    METHODS,
    POSITIONS,
    PRINTED_SOFT,
    SETTINGS,
    SHORT,
    bounded,
    drift_trial,
    effects,
    moving_offset_nT,
    quadric_trial,
    spiral,
    strength_nT,
    true_offset_nT,
)


@pytest.fixture(scope="module")
def short_settings():
    """The settings without the long runs."""
    patch = pytest.MonkeyPatch()
    short = tuple(s if s.iterations <= 200 else type(s)(s.label, s.reach_nT, iterations=300) for s in SETTINGS)
    patch.setattr(zhang2018_trials, "SETTINGS", short)
    yield
    patch.undo()


@pytest.fixture(scope="module")
def findings(short_settings):
    return Zhang2018(seeds=3).run()


def test_the_table_is_complete_and_has_the_printed_extremes():
    raw = np.abs(TOTAL_NT - PRINTED_F_NT)
    assert len(TOTAL_NT) == POSITIONS
    assert (raw.min(), raw.max()) == pytest.approx((96.1, 292.4), abs=0.01)
    for name, extremes in (("pso", (52.1, 92.4)), ("ga", (40.4, 72.1)), ("psoga", (30.5, 57.8))):
        assert len(AFTER_NT[name]) == POSITIONS
        assert (AFTER_NT[name].min(), AFTER_NT[name].max()) == extremes
    assert (AFTER_NT["psoga"] < AFTER_NT["ga"]).all()
    assert (AFTER_NT["ga"] < AFTER_NT["pso"]).all()
    assert (AFTER_NT["pso"] < raw).all()


def test_the_spiral_is_level_circles_at_one_degree_a_second():
    state = spiral(False)
    heading = np.unwrap(np.arctan2(state.R_wb[:, 1, 0], state.R_wb[:, 0, 0]))
    assert abs(heading[-1] - heading[0]) / state.time_s[-1] == pytest.approx(np.radians(1.0), rel=0.01)
    assert state.time_s[-1] == pytest.approx(3600.0, abs=15.0)
    assert np.abs(state.pos_enu_m[:, 2] + 3000.0).max() < 50.0
    assert np.degrees(np.abs(np.arcsin(state.R_wb[:, 2, 0]))).max() < 1.0


def test_the_true_offset_is_within_the_narrow_bounds():
    state = spiral(False)
    problem = bounded(state.field_nT + true_offset_nT(effects()), strength_nT(state), 1000.0)
    low = problem.middle_nT + problem.strength_nT * problem.lower[6:]
    np.testing.assert_allclose(low, -1000.0)
    assert np.abs(true_offset_nT(effects())).max() < 1000.0


def test_the_drift_is_the_catalogue_s():
    drift = next(e for e in effects() if e.name == "hard_iron_drift")
    assert np.linalg.norm(drift.rate_nT_h) == pytest.approx(DRIFT_NT_H, abs=0.1)


def test_drift_spoils_the_whole_fit_and_segments_save_it():
    trial = drift_trial(0)
    whole = trial.rms_nT["whole"]
    assert whole[0] < 3.0
    assert whole[-1] > 10 * whole[0]
    for name in ("segmented", "by turns"):
        assert trial.rms_nT[name][-1] < whole[-1] / 4
        assert trial.offset_nT[name][0] < 40.0
    assert trial.segments["whole"] == (1, 1, 1, 1)
    assert trial.segments["by turns"] == (5, 5, 5, 5)
    assert trial.segments["segmented"][0] == 1 < trial.segments["segmented"][-1]


def test_the_true_offset_moves_with_the_drift():
    state, none, ten = spiral(True), *(moving_offset_nT(spiral(True), effects(k)) for k in (0.0, 10.0))
    moved = np.linalg.norm(ten[-1] - none[-1])
    assert moved == pytest.approx(10 * DRIFT_NT_H * state.time_s[-1] / 3600, rel=0.01)
    np.testing.assert_allclose(none[0], true_offset_nT(effects()), atol=6.0)


def test_rows_state_what_was_found(findings):
    row = {r.what: r for r in findings.rows}
    assert len(row) == len(findings.rows) == 28
    assert all(one.judged.tolerance and one.judged.reason for one in findings.rows)
    assert row["raw error of the total field along one turn, nT, 30 positions"].holds
    assert not row["order of the rms over the record: PSOGA < GA < PSO"].holds
    assert not row["PSOGA < GA < PSO < raw at every printed position"].holds
    assert row["GA rebounds at times"].holds
    assert "c = 1.494" in row["PSO falls fast, then stalls (iterations 1 to 50)"].note
    drift = "whole-record ellipsoid fit is poor because the hard iron drifts: the catalogue's 17.5 nT/h"
    assert row[drift].verdict == "does not hold"
    assert row["the same at 50 times the catalogue's drift"].verdict == "holds"
    assert "by construction" in row["the same at 50 times the catalogue's drift"].note
    assert row["segmented ellipsoid fit is clearly better: cuts found by the program"].holds
    reduction = row["reduction of the error by PSOGA, from the printed table"]
    assert reduction.ours == "80 % at position 6, 69 % at position 28"
    for name in METHODS:
        assert row[f"error along the turn after {name} (100 individuals, 200 iterations), nT"].verdict == "better"


def test_equation_15_as_printed_leaves_what_it_drops():
    """Half of each mixed term: to first order the residual is F times half the mixed part of the unit direction."""
    printed, right = quadric_trial(0)
    assert right == pytest.approx(2.0, rel=0.1)
    form = np.linalg.inv(PRINTED_SOFT)
    form = form.T @ form
    state = spiral(True)
    unit = state.field_nT @ PRINTED_SOFT.T / strength_nT(state)
    mixed = (
        unit[:, 0] * unit[:, 1] * form[0, 1]
        + unit[:, 0] * unit[:, 2] * form[0, 2]
        + unit[:, 1] * unit[:, 2] * form[1, 2]
    )
    assert printed == pytest.approx(strength_nT(state) * np.sqrt(np.mean(mixed**2)) / 2, rel=0.1)
    assert quadric_row([(printed, right)]).verdict == "does not hold"


@pytest.mark.parametrize("method", LEAST_SQUARES.values(), ids=LEAST_SQUARES)
def test_every_least_squares_finds_an_exact_ellipsoid(method):
    rng = np.random.default_rng(7)
    unit = rng.standard_normal((300, 3))
    unit /= np.linalg.norm(unit, axis=1)[:, None]
    S, centre = np.array([[1.1, 0.05, 0.0], [0.0, 0.9, 0.1], [0.02, 0.0, 1.0]]), np.array([0.03, -0.02, 0.05])
    theta = method(design(unit @ S.T + centre))
    np.testing.assert_allclose(-np.linalg.solve(shape_matrix(theta), theta[6:]), centre, atol=1e-6)


def test_the_recursion_ends_at_the_ordinary_fit_and_the_total_fit_elsewhere():
    found = least_squares_trial(0)
    assert found.rms_nT["recursive"] == pytest.approx(found.rms_nT["ordinary"], rel=1e-4)
    assert found.offset_nT["recursive"] == pytest.approx(found.offset_nT["ordinary"], rel=1e-3)
    assert found.offset_nT["total"] != pytest.approx(found.offset_nT["ordinary"], rel=1e-3)


def test_pictures(findings):
    assert set(findings.figures) == {"convergence", "turn", "drift"}
    for draw in findings.figures.values():
        assert draw().axes[0].get_title()


def test_labels_of_the_settings_are_those_that_the_rows_use():
    labels = [setting.label for setting in SETTINGS]
    assert len(set(labels)) == len(labels)
    assert (labels[0], labels[3], labels[4]) == (MAIN, SHORT, LONGER)
    assert (SETTINGS[3].iterations, SETTINGS[4].iterations) == (50, 5000)


def test_settings_are_what_their_labels_say():
    by_label = {setting.label: setting for setting in SETTINGS}
    main = by_label[MAIN]
    assert main.label == f"bounds 10 % and {main.reach_nT:g} nT"
    assert by_label["same, mutation a tenth"].mutation == pytest.approx(main.mutation / 10)
    (learning,) = [setting for setting in SETTINGS if setting.c != main.c]
    assert learning.label == f"same, c1 = c2 = {learning.c:g}"
    for label in (SHORT, LONGER):
        assert label == f"same, {by_label[label].iterations} iterations"
    assert by_label[f"{MAIN}, drift ten times"].drift == 10 * main.drift
