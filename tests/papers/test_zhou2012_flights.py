"""[Zhou2012]'s twelve stops flown: headings, lean, and rows that a lean refutes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from papers.zhou2012.flight_rows import (
    QUADROTOR,
    TURNTABLE,
    VEHICLES,
    flight_rows,
    flight_trial,
    flown_stops,
)
from papers.zhou2012.trials import stops


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_every_vehicle_stops_at_twelve_headings_clockwise(vehicle: str) -> None:
    R_wb = flown_stops(vehicle, 0).R_wb
    heading = np.degrees(np.unwrap(np.arctan2(R_wb[:, 1, 0], R_wb[:, 0, 0])))
    np.testing.assert_allclose(np.diff(heading), -30.0, atol=1.0)
    np.testing.assert_allclose(flown_stops(vehicle, 0).field_enu_nT, stops().field_enu_nT)


def test_a_vehicle_at_rest_is_as_good_as_the_turntable_and_gusts_are_not() -> None:
    runs = {vehicle: [flight_trial((vehicle, seed)) for seed in range(4)] for vehicle in VEHICLES}
    lean = {vehicle: max(one.lean_deg for one in found) for vehicle, found in runs.items()}
    assert max(lean[vehicle] for vehicle in VEHICLES if vehicle != QUADROTOR) < 0.001 < 0.1 < lean[QUADROTOR]
    rows = flight_rows(runs)
    assert [row.verdict for row in rows] == ["holds"] * 4 + ["does not hold"] * 2
    # a lean of 0.1 degrees moves z by up to H sin(0.1 degrees), some 60 nT
    assert max(one.flat_nT for one in runs[QUADROTOR]) > 20.0


def test_errors_beyond_the_bound_are_told() -> None:
    good = flight_trial((TURNTABLE, 0))
    bad = replace(good, error=good.error + 1e-3)
    assert [flight_rows({TURNTABLE: [one]})[0].verdict for one in (good, bad)] == ["holds", "does not hold"]
