"""What to fly next: computed by the simulator, flown, and then the name stands alone."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenarios.toml import to_toml
from sim import effects as effect_table
from sim.chain import Chain
from sim.dataset import Recording
from sim.effects import Effects
from sim.scenario import Scenario, load
from sim.simulate import plan
from tests.validation.diagnosis.synthetic import FIELD_ENU_NT
from validation.diagnosis.onward import advice
from validation.diagnosis.onward.advice import Onward, _by_name, advised, onward
from validation.diagnosis.onward.legs import legs_of, measured_along
from validation.diagnosis.problem.pose import pose
from validation.diagnosis.workflow import diagnose

BASE: dict[str, Any] = {"hard_iron": {"offset_nT": [500.0, -300.0, 800.0]}, "white_noise": {"std_nT": [2.0] * 3}}
EDDY: dict[str, Any] = {"eddy_current": {"matrix_s": [[0.002, 0, 0], [0, 0.0025, 0.0003], [0, 0, 0.002]]}}


def _level() -> Scenario:
    """A level spiral at one rate, on which eddy currents look like a turned sensor."""
    quiet = ["navigation.attitude_noise_std_deg=0", "navigation.position_noise_std_m=0"]
    return load("auv-spiral", quiet).model_copy(update={"vary": {}, "effect_order": None, "effects": Effects(BASE)})


@cache
def _motion() -> Recording:
    """The level spiral without any error."""
    return measured_along(_level())


def _flown(scenario: Scenario, hidden: dict[str, Any], seed: int, recording: Recording | None = None) -> Recording:
    recording = recording or measured_along(scenario)
    state = pose(recording, plan(scenario, 0, 0).field_enu_nT, 5e4, ()).state
    effects = effect_table.build({**BASE, **hidden}, None, "test")
    return replace(recording, mag_nT=Chain(effects, seed).apply(state)[0])


def test_the_advised_leg_leaves_the_true_name_alone(tmp_path: Path) -> None:
    scenario = _level()
    found = advised(diagnose(_flown(scenario, EDDY, 1, _motion()), scenario))
    assert found.verdict == "not_observable"
    assert found.onward is not None
    assert found.onward.nats > found.problem.policy.apart
    assert found.advice[0].startswith("Next, fly")
    assert found.as_dict()["next"]["from"] == found.onward.other
    file = tmp_path / "next.toml"
    file.write_text(to_toml(found.onward.scenario))
    again = diagnose(_flown(load(str(file)), EDDY, 2), scenario)
    assert [(one.name, one.alternatives) for one in again.named] == [("eddy_current", ())]


def test_what_has_just_been_flown_is_not_offered() -> None:
    model = _level()
    first = legs_of(model)[0]
    assert first.words not in [leg.words for leg in legs_of(first.scenario)]


def test_a_fixed_station_is_not_told_to_fly() -> None:
    n = 3000
    rng = np.random.default_rng(3)
    temperature = 15 + 3 * np.sin(np.arange(n) / 400.0)
    mag_nT = FIELD_ENU_NT + temperature[:, None] * np.array([2.0, -1.0, 1.0]) + rng.normal(size=(n, 3))
    still = Recording(time_s=np.arange(n) / 2.0, mag_nT=mag_nT, temperature_degC=temperature)
    found = diagnose(still, _level(), field_enu_nT=FIELD_ENU_NT, fitted_base=True)
    assert found.problem.still
    assert onward(found).next is None
    assert not any("fly" in line.split() for line in advised(found).advice[:1])


def test_twins_are_told_as_such(monkeypatch: pytest.MonkeyPatch) -> None:
    scenario, moved = _level(), {"hard_iron": {"offset_nT": [530.0, -310.0, 790.0]}}
    found = diagnose(_flown(scenario, moved, 1, _motion()), scenario)
    first = legs_of(scenario)[:1]
    monkeypatch.setattr(advice, "legs_of", lambda model: first)
    assert ("hard_iron", "sensor_offset") in onward(found).same


def test_look_alikes_of_two_effects_of_a_name_are_listed_once() -> None:
    twice = Onward(None, (("hard_iron", "sensor_offset"), ("latency", "bandwidth"), ("hard_iron", "sensor_offset")))
    assert _by_name(twice) == [("hard_iron", ["sensor_offset"]), ("latency", ["bandwidth"])]
