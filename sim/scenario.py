"""Scenarios checked as a whole: the file itself, then the effects that it names."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from scenarios.load import load
from scenarios.names import find
from scenarios.spec import Scenario, SensorSpec
from sim import effects as effect_table
from sim.effects.base import Effect


def load_checked(name_or_path: str | Path, overrides: Sequence[str] = ()) -> Scenario:
    """The scenario of that name or file, with `key=value` overrides, every effect of it checked.

    Raises InputError (one line: file, key, what is wrong, what to do), see `scenarios.load.load` and
    `sim.effects.build`.
    """
    scenario = load(name_or_path, overrides)
    for index in range(len(scenario.sensors)):
        effects_of(scenario, index, str(find(name_or_path)))
    return scenario


def effects_of(scenario: Scenario, index: int = 0, where: str = "") -> tuple[Effect, ...]:
    """The effects of one sensor in the chain's order: the scenario's, then its own."""
    sensor: SensorSpec = scenario.sensors[index]
    tables = effect_table.merged(scenario.effects, sensor.effects)
    place = (where or f"scenario {scenario.name}") + (f": sensors.{index}" if sensor.effects else "")
    return effect_table.build(tables, scenario.effect_order, place)
