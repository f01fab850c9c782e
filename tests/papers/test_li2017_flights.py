"""Table 1 of [Li2017] flown: what the attitude's noise does to filters that take the attitude for exact."""

from __future__ import annotations

import numpy as np
import pytest

from papers.flights import flight
from papers.li2017.flight_rows import (
    MEASURED,
    QUADROTOR,
    TRUE,
    VEHICLES,
    FlightErrors,
    FlightTask,
    flight_rows,
    flight_trial,
    scenario_of,
)


@pytest.fixture(scope="module")
def errors() -> FlightErrors:
    return flight_trial(FlightTask(QUADROTOR, 0))


def test_flights_are_as_long_as_the_paper_s_and_excite_all_columns() -> None:
    state = flight(scenario_of(QUADROTOR), 0).state
    assert len(state) == 10_000
    columns = np.column_stack((np.full(len(state), 1e4), state.field_nT, state.field_rate_nT_s))
    assert np.linalg.cond(columns / np.linalg.norm(columns, axis=0)) < 20
    assert {scenario_of(vehicle).field for vehicle in VEHICLES} == {scenario_of(QUADROTOR).field}


def test_with_the_true_attitude_the_filters_are_those_of_the_even_turn(errors: FlightErrors) -> None:
    assert errors[TRUE, "kf"].state_error_pct[:3].mean() == pytest.approx(-99.98, abs=0.02)
    assert np.abs(errors[TRUE, "both"].state_error_pct).mean() < 2.0
    assert errors[TRUE, "constant"].component_nT.max() < 1.0


def test_the_measured_attitude_costs_the_forgetting_filter_most(errors: FlightErrors) -> None:
    assert errors[MEASURED, "both"].component_nT.max() > 100.0
    assert errors[MEASURED, "constant"].component_nT.max() < 20.0


def test_rows(errors: FlightErrors) -> None:
    rows = flight_rows({QUADROTOR: [errors]})
    assert len({row.what for row in rows}) == len(rows) == 5
    verdicts = [row.verdict for row in rows]
    assert (verdicts[0], verdicts[3], verdicts[4]) == ("same number", "does not hold", "not comparable")
    assert "attitude noise 0.02 degrees, gyro 1 mrad/s" in rows[3].note
