"""Scenarios in which everything varies: nothing was left out, every draw is a scenario, and runs differ."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.names import scenario_names
from scenarios.toml import as_dict
from scenarios.vary import apply_vary, values_at
from sim.effects import BY_NAME
from sim.scenario import Scenario, equipped, load
from sim.simulation import blocks, plan
from tests.short import short

FLEETS = [name for name in scenario_names() if name.endswith("-fleet")]
MATRIX = "effects.soft_iron.matrix"


@pytest.fixture(scope="module", params=FLEETS)
def fleet(request: pytest.FixtureRequest) -> Scenario:
    return load(str(request.param))


def test_every_part_of_it_varies(fleet: Scenario) -> None:
    """Each effect, Earth's field, the motion, the surroundings, the instruments, and the vehicle where it has keys."""
    keys = set(equipped(fleet).vary)
    assert {name for name in fleet.effects if not any(key.startswith(f"effects.{name}.") for key in keys)} == set()
    parts = {"field", "phases", "thermal", "navigation"} | (
        {"vehicle"} if len(as_dict(fleet)["vehicle"]) > 1 else set()
    )
    assert parts <= {key.split(".")[0] for key in keys}
    assert any(key.startswith("sensors.") for key in keys), "the sensor's tolerances"
    assert not {name for name in fleet.effects if BY_NAME[name].stage == "electronics"}


def test_runs_differ_in_all_that_varies(fleet: Scenario) -> None:
    whole = equipped(fleet)
    keys = sorted(whole.vary)
    runs = [values_at(apply_vary(whole, np.random.default_rng(seed)), keys) for seed in range(25)]
    assert all(len({str(run[key]) for run in runs}) > 1 for key in keys)
    for run in runs:
        np.testing.assert_array_equal(run[MATRIX], np.transpose(run[MATRIX]))


@pytest.mark.parametrize("name", FLEETS)
def test_another_run_is_another_recording(name: str) -> None:
    scenario = short(name)
    one, other = (list(blocks(plan(scenario, run))) for run in (0, 1))
    mag = [
        np.concatenate([[block[f"mag_{axis}_nT"] for axis in "xyz"] for block in run], axis=1) for run in (one, other)
    ]
    assert all(np.isfinite(field).all() for field in mag)
    assert np.abs(mag[0].mean(axis=1) - mag[1].mean(axis=1)).max() > 100
