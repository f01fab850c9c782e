"""The reproduction's own machinery, and its main findings on one seed."""

from __future__ import annotations

import numpy as np
import pytest

from calib.families.vector_filter import KalmanSettings, track
from calib.methods.kalman_rescaled import MICROTESLA
from papers.base import Findings
from papers.li2017.fuzzy_rows import exponent_row
from papers.li2017.paper import Li2017
from papers.li2017.rows import engine_row
from papers.li2017.trials import (
    CALM,
    CONSTANT,
    ENGINE_FILTERS,
    LOUD,
    NOISE_STD_NT,
    TRUE_STATE,
    compensated,
    engine_trial,
    exponent_trial,
    fuzzy_track,
    outcome,
    sensitivity_trial,
    simulated,
    total_equations,
    turning,
    vector_equations,
)


def test_truth_leaves_noise_alone():
    data = simulated(0, 3000)
    residual = data.difference_nT - data.observation() @ TRUE_STATE
    np.testing.assert_allclose(residual.std(axis=0), NOISE_STD_NT, rtol=0.05)
    error = compensated(TRUE_STATE, data) - data.field_nT
    assert error.std() < 2 * NOISE_STD_NT
    assert np.abs(vector_equations(TRUE_STATE, data)).mean() < 2 * NOISE_STD_NT
    assert np.abs(total_equations(TRUE_STATE, data)).mean() < 2 * NOISE_STD_NT


def test_noise_grows_in_the_last_third():
    data = simulated(0, 3000, loud=LOUD)
    residual = data.difference_nT - data.observation() @ TRUE_STATE
    assert residual[2000:].std() / residual[:2000].std() == pytest.approx(LOUD, rel=0.05)


def test_motion_excites_all_columns_and_has_the_right_rate():
    state = turning(10_000)
    difference = (state.field_nT[2:] - state.field_nT[:-2]) / (2 * state.interval_s)
    np.testing.assert_allclose(state.field_rate_nT_s[1:-1], difference, atol=3.0)
    columns = np.column_stack((np.full(10_000, 1e4), state.field_nT, state.field_rate_nT_s))
    assert np.linalg.cond(columns / np.linalg.norm(columns, axis=0)) < 20


def test_original_filter_leaves_the_permanent_field_behind_and_rescaling_finds_it():
    data = simulated(1)
    original = outcome(data, track(data, KalmanSettings()))
    rescaled = outcome(data, track(data, MICROTESLA))
    assert (original.state_error_pct[:3] < -99.9).all()
    assert np.abs(original.state_error_pct).mean() == pytest.approx(16.2, abs=1.5)
    assert np.abs(rescaled.state_error_pct).mean() < 0.4
    assert 2000 < rescaled.settled < 6000


def test_lengths_of_errors_are_told_apart():
    """The inequalities by which the paper's measure of error is told from its printed totals."""
    one = outcome(simulated(3), track(simulated(3), MICROTESLA))
    assert one.total_nT > np.linalg.norm(one.component_nT)
    assert one.strength_nT < one.total_nT < np.linalg.norm(one.component_rms_nT)


def test_a_state_that_does_not_move_gives_a_hundredth_of_the_error():
    data = simulated(4)
    forgetting, constant = outcome(data, track(data, MICROTESLA)), outcome(data, track(data, CONSTANT))
    assert constant.component_nT.max() < 0.5 < forgetting.component_nT.max()


def test_an_exponent_of_zero_is_the_ordinary_filter_and_one_is_not():
    zero, one = exponent_trial(0.0), exponent_trial(1.0)
    assert zero == 0.0
    assert one > 1.0
    assert exponent_row([zero, one]).verdict == "does not hold"


def test_filterpy_and_the_compiled_twin_end_at_the_same_parameters():
    engines = [engine_trial(name) for name in ENGINE_FILTERS]
    for one, other in engines:
        np.testing.assert_allclose(one, other, rtol=1e-6)
    assert engine_row(engines).verdict == "holds"
    assert engine_row([(one, 1.001 * other) for one, other in engines]).verdict == "does not hold"


def test_fuzzy_part_matters_only_where_the_state_variance_is_small():
    data = simulated(2, loud=LOUD)
    idle = (
        outcome(data, track(data, MICROTESLA)).state_error_pct
        - outcome(data, fuzzy_track(data, MICROTESLA)).state_error_pct
    )
    assert np.abs(idle).max() < 0.01
    fixed, adapted = outcome(data, track(data, CALM)), outcome(data, fuzzy_track(data, CALM))
    assert adapted.total_nT < 0.6 * fixed.total_nT
    assert (adapted.ratio, fixed.ratio) == (pytest.approx(1.0, abs=0.1), pytest.approx(50, rel=0.5))


@pytest.mark.slow
def test_every_row_is_judged():
    findings = Li2017(seeds=2).run(jobs=1)
    assert isinstance(findings, Findings)
    assert len(findings.rows) > 20
    assert all(row.paper and row.ours and row.judged.tolerance and row.judged.reason for row in findings.rows)
    assert all(draw() is not None for draw in findings.figures.values())


def test_a_larger_exponent_reaches_the_new_noise_sooner():
    found = sensitivity_trial(1)
    for window in (20, 50, 200):
        slow, usual, fast = (found[window, exponent][0] for exponent in (0.5, 1.0, 2.0))
        assert 0 < fast < usual < slow < 1000
