"""Read scenarios: by name from the catalogue, or from a TOML file; strictly, with overrides."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from scenarios.errors import InputError
from scenarios.files import read_text
from scenarios.names import CATALOGUE, find, scenario_names
from scenarios.overrides import Override, parse, put
from scenarios.paths.excited import Excited
from scenarios.problems import first_problem, problem_at
from scenarios.spec import Model, ModelSpec, Scenario
from scenarios.toml import as_dict, digest, to_toml
from scenarios.vary import apply_vary, check_vary

Spec = TypeVar("Spec", bound=BaseModel)


def load(name_or_path: str | Path, overrides: Sequence[str] = ()) -> Scenario:
    """The scenario of that name in the catalogue, or of that TOML file, with `key=value` overrides.

    Raises InputError (one line: file or override, key, what is wrong, what to do) for a file that cannot be read or is
    not TOML, an unknown key, a wrong type, a value out of range, and a phase that the vehicle cannot do.
    """
    path = find(name_or_path)
    changes = [parse(text) for text in overrides]
    scenario = _validate(Scenario, _changed(_read(path), changes), str(path), changes)
    _check_phases(scenario, str(path), changes)
    _check_effects(scenario, str(path), changes)
    check_vary(scenario, str(path))
    return scenario


def load_model(name_or_path: str | Path, overrides: Sequence[str] = ()) -> Model:
    """What the diagnosis takes as a model: a scenario, or a file with just a field and effects."""
    path = find(name_or_path)
    data = _read(path)
    if "phases" in data or "vehicle" in data:
        return load(path, overrides)
    changes = [parse(text) for text in overrides]
    model = _validate(ModelSpec, _changed(data, changes), str(path), changes)
    _check_effects(model, str(path), changes)
    return model


def catalogue() -> dict[str, str]:
    """Name and summary of every scenario in the catalogue."""
    tables = {name: _read(CATALOGUE / f"{name}.toml") for name in scenario_names()}
    return {name: str(table["summary"]) for name, table in tables.items()}


def _read(path: Path) -> dict[str, Any]:
    text = read_text(path, "give a readable TOML file in UTF-8", "utf-8-sig")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"not TOML: {error}", where=str(path), do="mend the file there") from None
    except (RecursionError, ValueError):  # tables in tables a thousand deep, a number of thousands of digits
        raise InputError("nested too deep, or a number too long", where=str(path), do="give a scenario file") from None


def _changed(data: dict[str, Any], changes: Sequence[Override]) -> dict[str, Any]:
    for change in changes:
        put(data, change)
    return data


def _validate(model: type[Spec], data: dict[str, Any], where: str, changes: Sequence[Override]) -> Spec:
    """Strictly: as JSON, so that arrays and dates are accepted, but no text for a number."""
    try:
        text = json.dumps(data, default=str)
    except RecursionError:
        raise InputError("tables nested too deep", where=where, do="give a scenario file") from None
    try:
        return model.model_validate_json(text, strict=True)
    except ValidationError as error:
        path, what, do = first_problem(error, model)
        raise problem_at(_blame(path, where, changes), path, what, do) from None


def _blame(path: tuple[str | int, ...], where: str, changes: Sequence[Override]) -> str:
    """The last override that reaches the path, otherwise the file."""
    return next((change.where for change in reversed(changes) if change.touches(path)), where)


def _check_phases(scenario: Scenario, where: str, changes: Sequence[Override]) -> None:
    vehicle = scenario.vehicle.kind
    for index, phase in enumerate(scenario.phases):
        if vehicle not in phase.vehicles:
            what = f'the {vehicle} cannot do a "{phase.kind}" phase'
            at: tuple[str | int, ...] = ("phases", index, "kind")
            raise problem_at(_blame(at, where, changes), at, what, "vehicles that can: " + ", ".join(phase.vehicles))
        if vehicle == "quadrotor" and isinstance(phase, Excited) and phase.excited:
            what = "the quadrotor cannot roll or pitch without moving away"
            at = ("phases", index)
            raise problem_at(_blame(at, where, changes), at, what, 'leave the amplitudes out, or add a "rotate" phase')


def _check_effects(spec: Scenario | ModelSpec, where: str, changes: Sequence[Override]) -> None:
    """Effects are tables or arrays of tables; their names and parameters are sim.effects' to check."""
    tables: list[tuple[tuple[str | int, ...], dict[str, Any]]] = [(("effects",), spec.effects)]
    if isinstance(spec, Scenario):
        tables += [(("sensors", i, "effects"), sensor.effects) for i, sensor in enumerate(spec.sensors)]
    for path, table in tables:
        for name, value in table.items():
            many = value if isinstance(value, list) and value else [value]
            if not all(isinstance(item, dict) for item in many):
                at = (*path, name)
                do = f"write [{'.'.join(map(str, at))}] and its parameters below"
                raise problem_at(_blame(at, where, changes), at, "an effect is a table of parameters", do)


__all__ = [
    "apply_vary",
    "as_dict",
    "catalogue",
    "digest",
    "load",
    "load_model",
    "to_toml",
]
