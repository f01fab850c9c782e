"""Scenarios whole: what the file says, typed down to the parameters of each effect and the vehicle's own table."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from scenarios import load as files
from scenarios.names import find
from scenarios.paths import Ability, Phase
from scenarios.problems import misfit
from scenarios.spec import BaseScenario, FieldSpec
from scenarios.table import Table
from scenarios.vary import check_vary
from sim.effects import EffectName, Effects, check_order, in_order
from sim.effects.base import Effect
from sim.vehicles import VEHICLES, VehicleSpec, able
from sim.vehicles.base import Vehicle

DIALECT = "https://json-schema.org/draft/2020-12/schema"
Metres = Annotated[float, Field(ge=-1000, le=1000)]
_EFFECTS = Field(Effects(), description="tables by effect name, each with its parameters")
_ORDER = Field(None, description="names of all effects, in another order than the physical one")


class SensorSpec(Table):
    """One magnetometer: where it sits (body frame), and effects of its own beside the scenario's."""

    position_m: tuple[Metres, Metres, Metres] = (0.0, 0.0, 0.0)
    effects: Effects = _EFFECTS


class Scenario(BaseScenario):
    """A whole scenario: field, vehicle, motion, sensors, effects, and which calibrators to try."""

    vehicle: VehicleSpec
    sensors: tuple[SensorSpec, ...] = Field((SensorSpec(),), min_length=1, max_length=9)
    effects: Effects = _EFFECTS
    effect_order: tuple[EffectName, ...] | None = _ORDER

    @model_validator(mode="after")
    def _fits(self) -> Self:
        for index, phase in enumerate(self.phases):
            _check_phase(VEHICLES[self.vehicle.kind], phase, index)
        for sensor in self.sensors:
            check_order(self.effect_order, (*self.effects, *sensor.effects))
        return self

    def chain(self, sensor: int = 0) -> tuple[Effect, ...]:
        """The effects of one sensor in the chain's order; of a name the scenario's first, then the sensor's own."""
        return in_order([self.effects, self.sensors[sensor].effects], self.effect_order)


class ModelSpec(Table):
    """A measurement model without a motion, which the diagnosis takes too."""

    name: str = Field("model", pattern=r"^[a-z0-9][a-z0-9_-]*$")
    summary: str = ""
    field: FieldSpec | None = None
    effects: Effects = _EFFECTS
    effect_order: tuple[EffectName, ...] | None = _ORDER

    @model_validator(mode="after")
    def _fits(self) -> Self:
        check_order(self.effect_order, self.effects)
        return self

    def chain(self) -> tuple[Effect, ...]:
        """The effects in the chain's order."""
        return in_order([self.effects], self.effect_order)


Model = ModelSpec | Scenario


def load(name_or_path: str | Path, overrides: Sequence[str] = ()) -> Scenario:
    """The scenario of that name in the catalogue, or of that TOML file, with `key=value` overrides; checked whole.

    Raises InputError as `scenarios.load.load` does, for a phase that the vehicle cannot do, an unknown effect or
    parameter, and a value that varies out of its range.
    """
    scenario = files.load(name_or_path, Scenario, overrides)
    check_vary(scenario, str(find(name_or_path)))
    return scenario


def load_model(name_or_path: str | Path, overrides: Sequence[str] = ()) -> Model:
    """What the diagnosis takes as a model: a scenario, or a file with just a field and effects."""
    if files.keys_of(name_or_path) & {"phases", "vehicle"}:
        return load(name_or_path, overrides)
    return files.load(name_or_path, ModelSpec, overrides)


def json_schema() -> dict[str, Any]:
    """JSON Schema (2020-12) of a scenario file, for editors."""
    return {"$schema": DIALECT, **Scenario.model_json_schema(by_alias=True)}


def _check_phase(vehicle: type[Vehicle], phase: Phase, index: int) -> None:
    """A phase that the vehicle can do; ValidationError at its place otherwise."""
    if not vehicle.can(phase):
        what = f'the {vehicle.name} cannot do a "{phase.kind}" phase'
        raise misfit(("phases", index, "kind"), what, "vehicles that can: " + ", ".join(able(phase)))
    if phase.tilted and Ability.TILT not in vehicle.abilities:
        what = f"the {vehicle.name} cannot {Ability.TILT}"
        raise misfit(("phases", index), what, 'leave the amplitudes out, or add a "rotate" phase')
