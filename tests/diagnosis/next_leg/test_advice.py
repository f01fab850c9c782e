"""What to fly next: computed by the simulator, flown, and then the name stands alone."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.next_leg import advice
from diagnosis.next_leg.advice import (
    FlightAdvice,
    NextFlight,
    _best_flight,
    _inflation_of,
    _inseparable_by_name,
    _leg_tables,
    advise_flight,
    advised,
)
from diagnosis.next_leg.legs import CandidateLeg, legs_of, measured_along
from diagnosis.policy import STANDARD
from diagnosis.problem.formulation import pose
from diagnosis.result import EvidenceKind
from diagnosis.workflow import diagnose
from recordings import Recording
from scenarios.toml import to_toml
from sim import effects as effect_table
from sim.chain import Chain
from sim.effects import EFFECTS, Effects
from sim.effects.parameters import Window
from sim.scenario import Scenario, load
from sim.simulation import plan
from tests.diagnosis.synthetic import FIELD_ENU_NT, problem

BASE: dict[str, Any] = {"hard_iron": {"offset_nT": [500.0, -300.0, 800.0]}, "white_noise": {"std_nT": [2.0] * 3}}
EDDY: dict[str, Any] = {"eddy_current": {"matrix_s": [[0.002, 0, 0], [0, 0.0025, 0.0003], [0, 0, 0.002]]}}

TWIN = next(effect.name for effect in EFFECTS if effect.traits.equivalent_to == "regional_field")


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
    state = pose(recording, plan(scenario, 0, 0).field_enu_nT, 5e4, ()).state
    effects = effect_table.build({**BASE, **hidden}, None, "test")
    return replace(recording, mag_nT=Chain(effects, seed).apply(state)[0])


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
    assert advise_flight(found).next is None
    assert not any("fly" in line.split() for line in advised(found).advice[:1])


def test_twins_are_told_as_such(monkeypatch: pytest.MonkeyPatch) -> None:
    scenario, moved = _level(), {"hard_iron": {"offset_nT": [530.0, -310.0, 790.0]}}
    found = diagnose(_flown(scenario, moved, 1, _motion()), scenario)
    first = legs_of(scenario)[:1]
    monkeypatch.setattr(advice, "legs_of", lambda model: first)
    assert ("hard_iron", "sensor_offset") in advise_flight(found).inseparable


def test_look_alikes_of_two_effects_of_a_name_are_listed_once() -> None:
    twice = FlightAdvice(
        None, (("hard_iron", "sensor_offset"), ("latency", "bandwidth"), ("hard_iron", "sensor_offset"))
    )
    assert _inseparable_by_name(twice) == [("hard_iron", ["sensor_offset"]), ("latency", ["bandwidth"])]


def _table(nats: float, active_s: Window = None, *, same: tuple[tuple[str, str], ...] = (), name: str = "one") -> Any:
    leg = CandidateLeg("a leg", _level(), 100.0)
    named = SimpleNamespace(name=name, effect=SimpleNamespace(active_s=active_s))
    return SimpleNamespace(cause=named, best=(leg, "other", nats) if nats else None, inseparable=same)


@pytest.mark.parametrize(("nats", "times"), [(100.0, 1), (5.0, 3), (0.2, 6)])
def test_a_leg_is_flown_until_it_brings_what_is_needed_and_more(nats: float, times: int) -> None:
    """Of ln(100) nats thrice as many; six times at most."""
    found = _best_flight(_table(nats), STANDARD)
    assert found is not None
    assert found.times == times
    assert found.needed_s == pytest.approx(100.0 * np.log(100) / nats)
    assert found.flight.scenario.phases == _level().phases * times
    assert _best_flight(_table(0.0), STANDARD) is None


def test_what_acted_in_a_part_of_the_run_is_to_act_on_the_leg() -> None:
    words = [one.words for window in (None, (12.0, 34.0)) if (one := _best_flight(_table(5.0, window), STANDARD))]
    assert ["with what acted from 12 s to 34 s at work" in one for one in words] == [False, True]


@pytest.mark.parametrize(("needed_s", "told"), [(59.0, "less than one is needed"), (120.0, "2.00 min are needed")])
def test_minutes_that_are_needed(needed_s: float, told: str) -> None:
    assert NextFlight("a", "b", CandidateLeg("a leg", _level(), 120.0), 9.0, needed_s, 1).words.endswith(told)


def _found(*named: Any, turns: bool = True) -> Any:
    return SimpleNamespace(named=named, problem=SimpleNamespace(turns=turns, policy=STANDARD))


def test_the_name_that_a_leg_serves_best_comes_first_and_what_none_tells_apart_is_listed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tables = [_table(5.0, same=(("one", "b"),)), _table(9.0, name="two"), _table(0.0, name="three")]
    monkeypatch.setattr(advice, "_leg_tables", lambda found: tables)
    field = SimpleNamespace(name="regional_field", alternatives=(TWIN, "soft_iron"))
    told = advise_flight(_found(field))
    assert told.next is not None
    assert told.next.name == "two"
    assert told.inseparable == (("regional_field", TWIN), ("one", "b"))
    at_rest = advise_flight(_found(field, turns=False))
    assert (at_rest.next, at_rest.inseparable) == (None, ())


@dataclass(frozen=True)
class Told:
    """What advice is added to."""

    advice: tuple[str, ...] = ("as before",)
    next_flight: Any = None


@pytest.mark.parametrize("flown", [True, False])
@pytest.mark.parametrize("same", [(("one", "b"),), ()])
def test_what_no_leg_tells_apart_is_said_with_or_without_one(
    flown: bool, same: tuple[tuple[str, str], ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    leg = _best_flight(_table(5.0), STANDARD) if flown else None
    monkeypatch.setattr(advice, "advise_flight", lambda found: FlightAdvice(leg, same))
    told = advised(Told())  # type: ignore[arg-type]
    first = [f"Next, {leg.words}."] if leg else []
    said = ["No leg that the simulator can fly distinguishes one and b."] if same else []
    assert told.advice == (*first, *said, "as before")
    assert (told.next_flight is not None) is flown


def test_legs_are_flown_only_for_names_that_have_look_alikes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Iron is refitted on them but where it is itself the name."""
    posed = problem(n=400)
    which = ((EvidenceKind.IRON, True), (EvidenceKind.HELD_OUT, True), (EvidenceKind.HELD_OUT, False))
    given = [SimpleNamespace(kind=how, listed=listed) for how, listed in which]
    monkeypatch.setattr(advice, "patch_model", lambda *_: SimpleNamespace(chain=tuple))
    monkeypatch.setattr(advice, "legs_of", lambda model: [SimpleNamespace(problem=lambda *_: None)])
    monkeypatch.setattr(advice, "pairs_of", lambda hand, one: [SimpleNamespace(listed=one.listed)])
    monkeypatch.setattr(advice.LegTable, "of", lambda one, hand, pairs, flown, V: (one, hand.iron, flown, V))
    found: Any = SimpleNamespace(problem=posed, model=None, named=given, after_nT=2 * posed.target * posed.sigma_nT)
    tables: Any = _leg_tables(found)
    assert [(one, iron, flown) for one, iron, flown, _ in tables] == [(given[0], False, []), (given[1], True, [])]
    assert [V for *_, V in tables] == [pytest.approx(_inflation_of(posed, 2 * posed.target))] * 2
    monkeypatch.setattr(advice, "legs_of", None)
    assert _leg_tables(SimpleNamespace(**vars(found) | {"named": given[2:]})) == []  # type: ignore[arg-type]


def test_a_rest_of_its_own_colour_inflates_and_none_deflates() -> None:
    posed, white = problem(n=4000), np.random.default_rng(0).normal(size=(4000, 3))
    assert _inflation_of(posed, white) < 2
    assert _inflation_of(posed, np.diff(white, axis=0, prepend=0.0)) == 1.0
    assert _inflation_of(posed, np.cumsum(white, axis=0) / 10) > 10
