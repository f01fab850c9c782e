"""A design says what decides every trial: points, calibrators, seed, versions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from recordings.resume import versions
from scenarios.errors import InputError
from scenarios.sweep import parse_sweep
from scenarios.toml import as_dict
from tests.short import short
from validation.calibrating.selection import select_calibrators
from validation.comparison.design import Design, received


def test_without_a_sweep_there_is_one_point_the_scenario_as_it_is() -> None:
    scenario = short("turntable-twelve-stops")
    found = Design.of(scenario, select_calibrators(["sphere", "ellipsoid"]))
    assert [point.scenario for point in found.points] == [scenario]
    assert (found.swept, found.seed) == ((), scenario.seed)
    assert found.calibrators == ("sphere", "ellipsoid", "uncorrected")


def test_a_sweep_names_its_keys_and_changes_nothing_else(design: Design) -> None:
    assert design.swept == ("effects.white_noise.std_nT",)
    assert [dict(point.values) for point in design.points] == [{design.swept[0]: 5.0}, {design.swept[0]: 50.0}]
    noises = [as_dict(point.scenario)["effects"]["white_noise"]["std_nT"] for point in design.points]
    assert [set(np.ravel(noise)) for noise in noises] == [{5.0}, {50.0}]
    assert design.seed == 5


def test_two_sweeps_are_combined() -> None:
    scenario = short("turntable-twelve-stops")
    sweeps = [parse_sweep(text, scenario) for text in ("noise_std_nT=5,50", "sampling.rate_hz=5,10")]
    found = Design.of(scenario, select_calibrators(["sphere"]), sweeps)
    assert len(found.points) == 4
    assert len({point.scenario.model_dump_json() for point in found.points}) == 4
    assert found.swept == ("effects.white_noise.std_nT", "sampling.rate_hz")


def test_a_sensor_of_an_array_has_its_number_from_one() -> None:
    found = Design.of(short("gradiometer-turntable"), select_calibrators(["sphere"]))
    assert found.calibrators == tuple(f"{name}@{k}" for name in ("sphere", "uncorrected") for k in (1, 2, 3, 4))


def test_the_identity_holds_all_that_decides_a_trial(design: Design) -> None:
    """Plain values of the second format; a journal of another format is another comparison."""
    told = design.identity()
    assert told["format"] == 2
    assert told["seed"] == 5
    assert told["packages"] == dict(versions())
    assert [point["values"] for point in told["points"]] == [{design.swept[0]: 5.0}, {design.swept[0]: 50.0}]
    assert [one["asked"]["calibrator"] for one in told["calibrators"].values()] == ["sphere", "ellipsoid"]
    for other in (replace(design, seed=6), replace(design, points=design.points[:1])):
        assert other.identity() != told


def test_a_value_that_does_not_fit_is_refused_at_once() -> None:
    scenario = short("turntable-twelve-stops")
    with pytest.raises(InputError, match="std_nT"):
        Design.of(scenario, select_calibrators(["sphere"]), [parse_sweep("noise_std_nT=5,-50", scenario)])


def test_what_is_sent_is_received_as_it_was(design: Design) -> None:
    assert received(design.sent) == design
    assert received(design.sent) is received(replace(design).sent)  # read once
