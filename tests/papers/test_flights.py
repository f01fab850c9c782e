"""Flights that the reproductions use: true state, rates, and what the instruments add."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from papers.flights import FlownRun, bare, flight


@pytest.fixture(scope="module")
def swaying() -> FlownRun:
    return flight(bare("quad-calibration", ["phases.1.duration_s=40"]), 3)


def test_the_state_is_one_motion(swaying: FlownRun) -> None:
    """Rates by finite differences of the attitude, the field's rate by those of the field."""
    state = swaying.state
    turns = Rotation.from_matrix(state.R_wb)
    between = (turns[:-1].inv() * turns[1:]).as_rotvec() / np.diff(state.time_s)[:, None]
    np.testing.assert_allclose((state.rate_rad_s[1:] + state.rate_rad_s[:-1]) / 2, between, atol=0.02)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", state.R_wb, state.field_nT), [state.field_enu_nT] * len(state))
    slope = (state.field_nT[2:] - state.field_nT[:-2]) / (state.time_s[2:] - state.time_s[:-2])[:, None]
    np.testing.assert_allclose(state.field_rate_nT_s[1:-1], slope, atol=600.0)
    assert np.abs(state.field_rate_nT_s).max() > 10_000.0


def test_there_are_no_magnetic_errors_and_the_instruments_are_those_of_the_scenario(swaying: FlownRun) -> None:
    np.testing.assert_array_equal(swaying.measured.mag_nT, swaying.state.field_nT)
    assert swaying.measured.att_q is not None
    assert swaying.measured.gyro_rad_s is not None
    seen = Rotation.from_quat(swaying.measured.att_q, scalar_first=True)
    error_deg = np.degrees((seen * Rotation.from_matrix(swaying.state.R_wb).inv()).as_rotvec())
    assert 0.005 < error_deg.std() < 0.04  # 0.02 degrees, correlated over the flight
    noise = swaying.measured.gyro_rad_s - swaying.state.rate_rad_s
    assert noise.std() == pytest.approx(1e-3, rel=0.05)


def test_a_seed_draws_another_wind(swaying: FlownRun) -> None:
    scenario = bare("quad-calibration", ["phases.1.duration_s=40"])
    other = flight(scenario, 4)
    assert np.abs(other.state.R_wb - swaying.state.R_wb).max() > 1e-3
    np.testing.assert_array_equal(flight(scenario, 3).state.R_wb, swaying.state.R_wb)
