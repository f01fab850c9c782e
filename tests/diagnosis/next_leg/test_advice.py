"""What to fly next: computed by the simulator, flown, and then the name stands alone."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.next_leg import legs
from diagnosis.next_leg.advice import LegTable, advised, inflation_of
from diagnosis.next_leg.legs import CandidateLeg, legs_of, measured_along
from diagnosis.policy import STANDARD
from diagnosis.problem.formulation import pose
from diagnosis.problem.known import Known
from diagnosis.workflow import diagnose
from recordings import Recording
from scenarios.toml import to_toml
from sim import effects as effect_table
from sim.chain import Chain
from sim.effects import Effects
from sim.scenario import Scenario, load
from sim.simulation import plan
from tests.diagnosis.synthetic import FIELD_ENU_NT, problem

BASE: dict[str, Any] = {"hard_iron": {"offset_nT": [500.0, -300.0, 800.0]}, "white_noise": {"std_nT": [2.0] * 3}}
EDDY: dict[str, Any] = {"eddy_current": {"matrix_s": [[0.002, 0, 0], [0, 0.0025, 0.0003], [0, 0, 0.002]]}}


def _level() -> Scenario:
    """A level spiral at one rate, on which eddy currents look like a turned sensor."""
    quiet = ["navigation.attitude_noise_std_deg=0", "navigation.position_noise_std_m=0"]
    half = load("auv-spiral", [*quiet, "phases.0.duration_s=900"])
    return half.model_copy(update={"vary": {}, "effect_order": None, "effects": Effects(BASE)})


@cache
def _motion() -> Recording:
    """The level spiral without any error."""
    return measured_along(_level())


def _flown(scenario: Scenario, hidden: dict[str, Any], seed: int, recording: Recording | None = None) -> Recording:
    recording = recording or measured_along(scenario)
    state = pose(recording, Known(plan(scenario, 0, 0).field_enu_nT, 5e4)).state
    effects = effect_table.build({**BASE, **hidden}, None, "test")
    return replace(recording, mag_nT=Chain(effects, seed).apply(state)[0])


@pytest.mark.slow
def test_the_advised_leg_leaves_the_true_name_alone(tmp_path: Path) -> None:
    scenario = _level()
    found = advised(diagnose(_flown(scenario, EDDY, 1, _motion()), scenario))
    assert found.verdict == "not_observable"
    assert found.next_flight is not None
    assert found.next_flight.nats > found.problem.policy.apart
    assert found.advice[0].startswith("Next, fly")
    assert found.as_dict()["next"]["from"] == found.next_flight.other
    file = tmp_path / "next.toml"
    file.write_text(to_toml(found.next_flight.scenario))
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
    assert advised(found) is found


def test_twins_are_told_as_such(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two effects that agree on every motion: said once for a name, whatever the legs show."""
    scenario, moved = _level(), {"hard_iron": {"offset_nT": [530.0, -310.0, 790.0]}}
    found = diagnose(_flown(scenario, moved, 1, _motion()), scenario)
    monkeypatch.setattr(legs, "LEGS", legs.LEGS[1:2])
    remarks = [line for line in advised(found).advice if line.startswith("No leg that the simulator can fly")]
    assert len(remarks) == 1
    assert {"hard_iron", "sensor_offset"} <= {word.strip(",.") for word in remarks[0].split()}


def _table(nats: Any, *listed: bool) -> LegTable:
    """A name beside look-alikes a and b, and the nats of a first and a second leg."""
    pairs: Any = [
        SimpleNamespace(listed=one, second=SimpleNamespace(name=name)) for one, name in zip(listed, "ab", strict=False)
    ]
    name: Any = SimpleNamespace(name="name", alternatives=())
    return LegTable(name, pairs, [CandidateLeg(words, _level()) for words in ("1", "2")], np.array(nats), STANDARD)


@pytest.mark.parametrize(
    ("nats", "listed", "best", "same"),
    [
        (((10.0, 4.0), (1.0, 3.0)), (True, True), ("2", "b", 3.0), ""),
        (((4.0, 10.0), (0.05, 0.02)), (True, True), ("2", "a", 10.0), "b"),
        (((10.0, 4.0), (1.0, 3.0)), (True, False), ("2", "a", 4.0), ""),
        (((10.0, 4.0), (0.05, 0.05)), (True, False), ("1", "a", 10.0), ""),
        (((0.05, 0.02), (1.0, 3.0)), (True, False), None, "a"),
        (((5.0, 0.0), (0.0, 5.0)), (True, True), None, ""),
    ],
)
def test_the_leg_that_tells_the_least_apart_best_is_flown(nats, listed, best, same) -> None:  # type: ignore[no-untyped-def]
    """What no leg tells apart does not choose it; what is no look-alike does, and is not told."""
    table = _table(nats, *listed)
    flight = table.flight
    assert (flight and (flight.leg, flight.other, flight.nats)) == best
    assert table.inseparable == list(same)


@pytest.mark.parametrize(("nats", "times"), [(100.0, 1), (5.0, 3), (0.2, 6)])
def test_a_leg_is_flown_until_it_brings_what_is_needed_and_more(nats: float, times: int) -> None:
    """Of ln(100) nats thrice as many; six times at most."""
    flight = _table([[nats, 0.0]], True).flight
    assert flight is not None
    assert flight.needed_s == pytest.approx(900.0 * np.log(100) / nats)
    assert flight.scenario.phases == _level().phases * times


def test_a_rest_of_its_own_colour_inflates_and_none_deflates() -> None:
    posed, white = problem(n=4000), np.random.default_rng(0).normal(size=(4000, 3))
    assert inflation_of(posed, white) < 2
    assert inflation_of(posed, np.diff(white, axis=0, prepend=0.0)) == 1.0
    assert inflation_of(posed, np.cumsum(white, axis=0) / 10) > 10
