"""All effects in their physical order, and the way from a scenario's tables to them and back.

To add one: a class in a file of this package, and a line in EFFECTS. Injection, labels, checks, `list effects`, the
editor's schema, the diagnosis and the contract tests follow.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from pydantic import TypeAdapter

from scenarios.errors import InputError
from sim.effects.base import Effect
from sim.effects.currents import CurrentRipple, EddyCurrent, MotorCurrent
from sim.effects.drift import OffsetJump, OffsetRandomWalk, SensorOffset
from sim.effects.dynamic import Bandwidth, Latency
from sim.effects.earth import AttitudeMisalignment, DiurnalDrift, FieldGradient
from sim.effects.electronics import Quantisation, Saturation
from sim.effects.faults import Dropouts, Spikes
from sim.effects.geometry import Misalignment, NonOrthogonality, Scale
from sim.effects.iron import HardIron, HardIronDrift, SoftIron
from sim.effects.noise import FlickerNoise, WhiteNoise
from sim.effects.nonlinear import Hysteresis, Nonlinearity
from sim.effects.sources import LocalDipole
from sim.effects.temperature import TemperatureOffset, TemperatureScale

EFFECTS: tuple[type[Effect], ...] = (
    # field
    DiurnalDrift,
    FieldGradient,
    LocalDipole,
    AttitudeMisalignment,
    # vehicle
    SoftIron,
    HardIron,
    HardIronDrift,
    EddyCurrent,
    MotorCurrent,
    CurrentRipple,
    # sensor
    Misalignment,
    NonOrthogonality,
    Scale,
    Nonlinearity,
    TemperatureScale,
    TemperatureOffset,
    Hysteresis,
    Bandwidth,
    SensorOffset,
    OffsetJump,
    OffsetRandomWalk,
    FlickerNoise,
    WhiteNoise,
    # electronics; the delay interpolates, so it comes before the rounding
    Latency,
    Saturation,
    Quantisation,
    Spikes,
    Dropouts,
)
"""Every effect, in the order in which the chain applies them unless a scenario gives another."""

BY_NAME: dict[str, type[Effect]] = {cls.name: cls for cls in EFFECTS}


def find(name: str, where: str) -> type[Effect]:
    """The class of an effect; InputError with the nearest names if there is none."""
    if name in BY_NAME:
        return BY_NAME[name]
    near = difflib.get_close_matches(name, BY_NAME, n=3) or list(BY_NAME)
    raise InputError(f"no effect {name!r}", where=where, do="did you mean " + ", ".join(near) + "?")


def build(tables: Mapping[str, Any], order: Sequence[str] | None, where: str) -> tuple[Effect, ...]:
    """The effects of a scenario's `effects` tables, in the chain's order.

    Parameters
    ----------
    tables : name -> table of parameters, or an array of tables for several effects of one kind.
    order : names in another order than the physical one; it must name all that are present.
    where : the file, for messages.

    Raises
    ------
    InputError : unknown effect or parameter, wrong type or shape, not finite, out of bounds, incomplete order.
    """
    prefix = f"{where}: effects" if where else "effects"
    made = {name: tuple(_instances(find(name, prefix), table, f"{prefix}.{name}")) for name, table in tables.items()}
    names = tuple(BY_NAME) if order is None else _checked_order(order, tables, where)
    return tuple(effect for name in names for effect in made.get(name, ()))


def table(effect: Effect) -> dict[str, Any]:
    """The effect as a table for TOML: every parameter, tuples as lists."""
    return {p.name: _plain(getattr(effect, p.name)) for p in effect.parameters()}


def as_tables(effects: Sequence[Effect]) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Tables and order from which `build` makes the same effects; of one kind all must follow each other."""
    names = tuple(dict.fromkeys(effect.name for effect in effects))
    grouped = {name: [table(effect) for effect in effects if effect.name == name] for name in names}
    if [effect.name for effect in effects] != [name for name in names for _ in grouped[name]]:
        raise InputError("effects of one kind must follow each other", where="effects", do="reorder them")
    return {name: parts[0] if len(parts) == 1 else parts for name, parts in grouped.items()}, names


def merged(tables: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    """A scenario's tables with a sensor's own beside them: both apply, the scenario's first."""
    shared = {name: [*_listed(tables[name]), *_listed(own[name])] for name in own if name in tables}
    return {**tables, **own, **shared}


def summary(name: str) -> str:
    """The first sentence of an effect's documentation."""
    return " ".join((find(name, "effects").__doc__ or "").split("\n\n")[0].split())


def describe(name: str) -> str:
    """An effect's documentation and its parameters with unit, bounds, default and meaning."""
    cls = find(name, "effects")
    lines = [f"{name} ({cls.stage}): {summary(name)}"]
    lines += ["    " + line.strip() for line in (cls.__doc__ or "").split("\n")[1:] if line.strip()]
    for p in cls.parameters():
        bounds = ", ".join(p.options) or f"{p.low:g} to {p.high:g} {p.unit}".rstrip()
        lines.append(f"  {p.name} = {_plain(p.default)}  ({bounds}): {p.doc}")
    return "\n".join(lines)


def json_schema() -> dict[str, dict[str, Any]]:
    """JSON Schema of each effect's table (or array of tables), for editors."""
    return {name: _either(_table_schema(cls)) for name, cls in BY_NAME.items()}


def _instances(cls: type[Effect], given: Any, where: str) -> Iterable[Effect]:
    if isinstance(given, Mapping):
        yield _made(cls, given, where)
    elif isinstance(given, list | tuple) and all(isinstance(part, Mapping) for part in given):
        for i, part in enumerate(given):
            yield _made(cls, part, f"{where}[{i}]")
    else:
        raise InputError(f"expected a table or an array of tables, found {given!r}", where=where)


def _made(cls: type[Effect], given: Mapping[str, Any], where: str) -> Effect:
    try:
        return cls(**given)
    except InputError as error:
        raise InputError(error.what, where=where + error.where.removeprefix(cls.name), do=error.do) from None


def _checked_order(order: Sequence[str], present: Iterable[str], where: str) -> tuple[str, ...]:
    place = f"{where}: effect_order" if where else "effect_order"
    for name in order:
        find(name, place)
        if list(order).count(name) > 1:
            raise InputError(f"{name} is named twice", where=place)
    if missing := [name for name in present if name not in order]:
        raise InputError(f"does not name {', '.join(missing)}", where=place, do="name every effect of the scenario")
    return tuple(order)


def _plain(value: Any) -> Any:
    return [_plain(part) for part in value] if isinstance(value, tuple) else value


def _listed(table: Any) -> list[Any]:
    return list(table) if isinstance(table, list | tuple) else [table]


def _either(schema: dict[str, Any]) -> dict[str, Any]:
    return {"anyOf": [schema, {"type": "array", "items": schema}]}


def _table_schema(cls: type[Effect]) -> dict[str, Any]:
    return TypeAdapter(cls).json_schema() | {"title": cls.name, "description": summary(cls.name)}
