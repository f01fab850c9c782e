"""What a value of the scenario does to the bound: the standard case's own figures along its pitch."""

from __future__ import annotations

import re

import numpy as np
import pytest

from scenarios.sweep import parse_sweep
from sim.scenario import load
from validation.bound.limit import Tilts
from validation.bound.query import BoundQuery, WhatIf
from validation.bound.summary import (
    NOT_OBSERVABLE,
    headline,
    summary,
    what_if_headline,
    what_if_heads,
    what_if_rows,
    what_if_summary,
)


@pytest.fixture(scope="module")
def found() -> WhatIf:
    scenario = load("standard-auv")
    sweep = parse_sweep("pitch_amplitude_deg=5,45", scenario, "--what-if")
    return WhatIf.of(BoundQuery(noise_std_nT=10.0), scenario, sweep)


def test_the_pitch_of_the_standard_case(found: WhatIf) -> None:
    """The bounds of `auv` and `pitch`; the run-ins add 20 s to 360 s."""
    assert [one.bound.offset_rms_nT for one in found.answers] == pytest.approx([423.6, 7.589], rel=0.05)


def test_each_value_has_a_row(found: WhatIf) -> None:
    rows = what_if_rows(found)
    assert [row[0] for row in rows] == ["5", "45"]
    assert {len(row) for row in rows} == {len(what_if_heads(found))}
    assert "error is least at phases.0.pitch_amplitude_deg = 45" in what_if_headline(found)


def test_as_json(found: WhatIf) -> None:
    told = what_if_summary(found)
    assert told["key"] == "phases.0.pitch_amplitude_deg"
    assert [point["value"] for point in told["points"]] == [5, 45]
    assert set(told["points"][0]["scores"]) >= {"heading_rms_deg", "figure_of_merit_nT"}


def test_the_gyros_noise_as_stated() -> None:
    """At one that is perfect strength and gyro tell more than at the scenario's."""
    scenario = load("standard-auv")
    stated, perfect = (BoundQuery("norm+gyro", gyro_std_rad_s=std).of_scenario(scenario) for std in (None, 1e-5))
    assert stated.known.gyro_std_rad_s == scenario.navigation.gyro_noise_std_rad_s
    assert perfect.bound.offset_rms_nT < 0.5 * stated.bound.offset_rms_nT


def test_the_limit_of_tilts_in_words_and_as_json() -> None:
    found = BoundQuery("vector", tilts=Tilts(5.0, 5.0)).of_scenario(load("standard-auv"))
    assert found.limit is not None
    told = summary(found)["limit"]
    assert told["offset_rms_nT"] < found.bound.offset_rms_nT
    assert 0 <= told["duality_gap"] < 0.01
    assert re.search(r"within a roll of 5 and a pitch of 5 degrees .* duality gap", headline(found).replace("(", " "))


def test_what_is_not_told_is_said_so() -> None:
    scenario = load("turntable-twelve-stops")
    found = WhatIf.of(BoundQuery(), scenario, parse_sweep("dwell_s=5,10", scenario))
    assert all(np.isinf(one.bound.offset_rms_nT) for one in found.answers)
    assert all(NOT_OBSERVABLE in row for row in what_if_rows(found))
    assert "cannot be determined at any of these values" in what_if_headline(found)
