"""Complete scenarios: a scenario file, typed down to the parameters of each effect and the vehicle's table."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Self, TypeVar

from pydantic import Field, model_validator

from scenarios import load as files
from scenarios.names import find
from scenarios.paths import Ability, Phase
from scenarios.problems import misfit
from scenarios.spec import DIALECT, BaseScenario, FieldSpec, NavigationSpec
from scenarios.table import Table
from scenarios.vary import check_vary
from sim.effects import EffectName, Effects, check_order, in_order
from sim.effects.base import Effect
from sim.scalar import OUTSIDE
from sim.sensors import SENSORS, Sensor, SensorName
from sim.vehicles import VEHICLES, VehicleSpec, vehicles_for
from sim.vehicles.base import Vehicle

Metres = Annotated[float, Field(ge=-1000, le=1000)]
S = TypeVar("S", bound="Scenario")
_EFFECTS = Field(Effects(), description="tables by effect name, each with its parameters")
_ORDER = Field(None, description="names of all effects, in another order than the physical one")


class InstrumentSpec(Table):
    """The default kind of the magnetometers."""

    kind: SensorName = Field(description="a sensor by name, with its data sheet's figures")


class SensorSpec(Table):
    """A magnetometer: position (body frame), kind, and effects in addition to the scenario's."""

    position_m: tuple[Metres, Metres, Metres] = (0.0, 0.0, 0.0)
    kind: SensorName | None = Field(None, description="a sensor by name, in place of that of `[sensor]`")
    effects: Effects = _EFFECTS


class Scenario(BaseScenario):
    """A complete scenario: field, vehicle, motion, sensors, effects, and the calibrators to try."""

    vehicle: VehicleSpec
    sensor: InstrumentSpec | None = None
    sensors: tuple[SensorSpec, ...] = Field((SensorSpec(),), min_length=1, max_length=9)
    effects: Effects = _EFFECTS
    effect_order: tuple[EffectName, ...] | None = _ORDER

    @model_validator(mode="after")
    def _fits(self) -> Self:
        for index, phase in enumerate(self.phases):
            _check_phase(VEHICLES[self.vehicle.kind], phase, index)
        check_kinds(self)
        for tables in equipped(self).sensors:
            check_order(self.effect_order, (*self.effects, *tables.effects))
        return self

    def sheet(self, sensor: int) -> Sensor | None:
        """The data sheet of a sensor, None where the scenario names no kind."""
        kind = self.sensors[sensor].kind or (self.sensor.kind if self.sensor else None)
        return SENSORS[kind] if kind else None

    @property
    def vectors(self) -> tuple[int, ...]:
        """Indices of the vector magnetometers, in order."""
        return tuple(k for k in range(len(self.sensors)) if not is_scalar(self, k))

    @property
    def scalar(self) -> int | None:
        """Index of the scalar magnetometer, None without."""
        return next((k for k in range(len(self.sensors)) if is_scalar(self, k)), None)

    def chain(self, sensor: int | None = None) -> tuple[Effect, ...]:
        """The effects of a sensor, by default the first vector magnetometer, in the order of the chain.

        Of each name the scenario's effects come first, then the sensor's; effects of the data sheet apply where neither
        has the name. A scalar magnetometer has, of the scenario's effects, only those of field and vehicle.
        """
        number = self.vectors[0] if sensor is None else sensor
        effects = in_order([self.effects, equipped(self).sensors[number].effects], self.effect_order)
        if not is_scalar(self, number):
            return effects
        shared = [one for group in self.effects.values() for one in group if one.stage not in OUTSIDE]
        return tuple(one for one in effects if not any(one is other for other in shared))


def is_scalar(scenario: Scenario, sensor: int) -> bool:
    """Whether a sensor is a scalar magnetometer."""
    sheet = scenario.sheet(sensor)
    return sheet is not None and sheet.scalar


def check_kinds(scenario: Scenario) -> None:
    """ValidationError unless the sensors' kinds are compatible and fast enough for the sample rate."""
    scalars = len(scenario.sensors) - len(scenario.vectors)
    if scalars > 1 or not scenario.vectors:
        what = f"{scalars} of {len(scenario.sensors)} sensors give the field's strength alone"
        raise misfit(("sensors",), what, "have at most one of them, beside one that measures three axes")
    for sensor in range(len(scenario.sensors)):
        sheet = scenario.sheet(sensor)
        if sheet and sheet.fastest_hz and scenario.sampling.rate_hz > sheet.fastest_hz:
            what = f"the {sheet.name} gives at most {sheet.fastest_hz:g} samples a second"
            raise misfit(("sampling", "rate_hz"), what, "lower the rate, or choose another sensor")


def equipped(scenario: S) -> S:
    """The scenario with the sensors' data sheets written out: effects of each sensor, tolerances as `vary`.

    Tables of the scenario stay unchanged and replace the tables of the data sheet, tolerances included.
    """
    sensors, vary = list(scenario.sensors), dict(scenario.vary)
    for number, sensor in enumerate(scenario.sensors):
        if sheet := scenario.sheet(number):
            said = {*sensor.effects} if sheet.scalar else {*sensor.effects, *scenario.effects}
            new = {name: table for name, table in sheet.tables(scenario.sampling.rate_hz).items() if name not in said}
            sensors[number] = sensor.model_copy(update={"effects": Effects({**new, **sensor.effects.written})})
            for (name, parameter), how in sheet.spread().items():
                if name in new:
                    vary.setdefault(f"sensors.{number}.effects.{name}.{parameter}", how)
    return scenario.model_copy(update={"sensors": tuple(sensors), "vary": vary})


class ModelSpec(Table):
    """A measurement model without a motion, as input of the diagnosis."""

    name: str = Field("model", pattern=r"^[a-z0-9][a-z0-9_-]*$")
    summary: str = ""
    field: FieldSpec | None = None
    navigation: NavigationSpec = NavigationSpec(attitude_noise_std_deg=0.0)
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
    """The scenario of a name in the catalogue, or of a TOML file, with `key=value` overrides; fully checked.

    Raises InputError as `scenarios.load.load` does, for a phase impossible for the vehicle, an unknown effect or
    parameter, and a varied value out of range.

    >>> load("tumble", ["phases.0.duration_s=60"]).phases[0].duration_s
    60.0
    """
    scenario = files.load(name_or_path, Scenario, overrides)
    check_vary(equipped(scenario), str(find(name_or_path)))
    return scenario


def load_model(name_or_path: str | Path, overrides: Sequence[str] = ()) -> Model:
    """A model for the diagnosis: a scenario, or a file with just a field and effects."""
    if files.keys_of(name_or_path) & {"phases", "vehicle"}:
        return load(name_or_path, overrides)
    return files.load(name_or_path, ModelSpec, overrides)


def json_schema() -> dict[str, Any]:
    """JSON Schema (2020-12) of a scenario file, for editors."""
    return {"$schema": DIALECT, **Scenario.model_json_schema(by_alias=True)}


def _check_phase(vehicle: type[Vehicle], phase: Phase, index: int) -> None:
    """ValidationError, with the place, for a phase impossible for the vehicle."""
    if not vehicle.can(phase):
        what = f'the {vehicle.name} cannot do a "{phase.kind}" phase'
        raise misfit(("phases", index, "kind"), what, "vehicles that can: " + ", ".join(vehicles_for(phase)))
    if phase.tilted and Ability.TILT not in vehicle.abilities:
        what = f"the {vehicle.name} cannot {Ability.TILT}"
        raise misfit(("phases", index), what, 'leave the amplitudes out, or add a "rotate" phase')
