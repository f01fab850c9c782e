"""The magnetometer of the field's strength: what it sees, and that it leaves the others alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from calib import CALIBRATORS
from calib.base import Reference
from recordings import read_run
from sim.dataset_writer import generate
from sim.scenario import Scenario
from sim.simulation import blocks, plan
from tests.short import short

PLACE = "position_m=[0.5, 0, 0.2]"
QUIET = "effects={white_noise={std_nT=0}, sensor_offset={}}"


def scenario(*sensors: str) -> Scenario:
    return short("auv-spiral-excited", f"sensors=[{', '.join(sensors)}]", "effects.white_noise=")


def columns(given: Scenario) -> dict[str, Any]:
    pieces = list(blocks(plan(given)))
    return {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}


def test_it_measures_the_length_of_the_field_with_the_vehicles() -> None:
    found = columns(scenario(f"{{{PLACE}}}", f'{{kind="g_882", {PLACE}, {QUIET}}}'))
    field = np.column_stack([found[f"mag_{axis}_nT"] for axis in "xyz"])
    np.testing.assert_allclose(found["scalar_nT"], np.linalg.norm(field, axis=1), rtol=1e-13)
    true = np.column_stack([found[f"true_field_{axis}_nT"] for axis in "xyz"])
    assert np.abs(found["scalar_nT"] - np.linalg.norm(true, axis=1)).max() > 100


def test_effects_of_the_other_sensors_do_not_reach_it() -> None:
    own = "effects={scale={error=0.1}, white_noise={std_nT=50}}"
    one, other = (columns(scenario(sensor, f'{{kind="g_882", {QUIET}}}')) for sensor in ("{}", f"{{{own}}}"))
    np.testing.assert_array_equal(one["scalar_nT"], other["scalar_nT"])
    assert np.any(one["mag_x_nT"] != other["mag_x_nT"])


def test_its_noise_and_offset_are_those_of_the_sheet() -> None:
    quiet, real = (columns(scenario("{}", f'{{kind="g_882"{more}}}')) for more in (f", {QUIET}", ""))
    error = real["scalar_nT"] - quiet["scalar_nT"]
    assert abs(error.mean()) <= 2.0
    assert error.std() == pytest.approx(0.004 * np.sqrt(10 / 2), rel=5 / np.sqrt(2 * len(error)))


def test_the_others_are_as_they_were_without_it() -> None:
    noisy = "{effects={white_noise={std_nT=5}}}"
    without = columns(scenario(noisy))
    for order in ((noisy, '{kind="g_882"}'), ('{kind="g_882"}', noisy)):
        beside = columns(scenario(*order))
        for name, values in without.items():
            np.testing.assert_array_equal(beside[name], values, err_msg=name)


def test_a_data_set_holds_it_as_a_channel_that_its_calibrator_takes(tmp_path: Any) -> None:
    generate(scenario("{}", '{kind="g_882"}'), tmp_path)
    recording, truth = read_run(tmp_path)
    assert "sensor_offset" in truth.parameters["scalar"]
    east, north, up = truth.parameters["field_enu_nT"]
    reference = Reference(float(np.linalg.norm([east, north, up])), (east, north, up))
    found = CALIBRATORS["tolles_lawson"]().fit(recording, reference, np.random.default_rng(0))
    assert found.status.kind != "not_applicable"
