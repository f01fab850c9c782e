"""[Long2013]'s calibration from flown motions: what each vehicle's turns determine."""

from __future__ import annotations

import numpy as np
import pytest

from papers.flights import flight
from papers.long2013.flight_rows import (
    AUV,
    QUADROTOR,
    TURNTABLE,
    VEHICLES,
    FlownCalibration,
    flight_rows,
    flight_trial,
    scenario_of,
)
from papers.long2013.trials import NED_TO_ENU, field_ned_nT


@pytest.fixture(scope="module")
def runs() -> dict[str, list[FlownCalibration]]:
    return {vehicle: flight_trial((vehicle, 3)) for vehicle in VEHICLES}


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_every_vehicle_flies_in_the_paper_s_field(vehicle: str) -> None:
    state = flight(scenario_of(vehicle), 0).state
    np.testing.assert_allclose(state.field_enu_nT, NED_TO_ENU @ field_ned_nT(), atol=0.1)
    assert 1200 <= len(state) <= 1800


def test_the_whole_sphere_fixes_the_iron_and_a_sway_does_not(runs: dict[str, list[FlownCalibration]]) -> None:
    assert {one.status for one in (*runs[TURNTABLE], *runs[AUV])} == {"ok"}
    assert {one.status for one in runs[QUADROTOR]} == {"unobservable"}
    offset = [np.median([one.offset_nT for one in runs[vehicle]]) for vehicle in VEHICLES]
    assert offset == sorted(offset)
    assert all(one.own_pct < 2.0 for found in runs.values() for one in found)


def test_rows(runs: dict[str, list[FlownCalibration]]) -> None:
    rows = flight_rows(runs)
    assert len({row.what for row in rows}) == len(rows) == 9
    verdict = {row.what: row.verdict for row in rows}
    for vehicle in (TURNTABLE, AUV):
        assert {v for what, v in verdict.items() if what.startswith(vehicle)} == {"holds"}
    assert verdict[f"{QUADROTOR} flown: largest deviation of the corrected field strength"] == "does not hold"
    assert "fits: 3 unobservable" in rows[-1].note
