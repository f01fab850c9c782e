"""Strict reading of scenarios, by name from the catalogue or from a TOML file, with overrides."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from scenarios.errors import InputError
from scenarios.files import read_text
from scenarios.names import CATALOGUE, find, scenario_names
from scenarios.nesting import parsed_toml
from scenarios.overrides import Override, parse, put
from scenarios.problems import first_problem, problem_at

Spec = TypeVar("Spec", bound=BaseModel)


def load(name_or_path: str | Path, model: type[Spec], overrides: Sequence[str] = ()) -> Spec:
    """Return a scenario of the catalogue, or a TOML file, as a `model`, with `key=value` overrides.

    Raises InputError (one line: file or override, key, what is wrong, what to do) for a file that cannot be read or is
    not TOML, an unknown key, a wrong type, a value out of range, and every further violation of the model.
    """
    path = find(name_or_path)
    changes = [parse(text) for text in overrides]
    return _validate(model, _changed(_read(path), changes), str(path), changes)


def keys_of(name_or_path: str | Path) -> frozenset[str]:
    """Return the top-level keys of a file."""
    return frozenset(_read(find(name_or_path)))


def catalogue() -> dict[str, str]:
    """Return name and summary of every scenario in the catalogue.

    >>> catalogue()["tumble"].split(":")[0]
    'Turntable over the whole sphere'
    """
    tables = {name: _read(CATALOGUE / f"{name}.toml") for name in scenario_names()}
    return {name: str(table["summary"]) for name, table in tables.items()}


def _read(path: Path) -> dict[str, Any]:
    text = read_text(path, "give a readable TOML file in UTF-8", "utf-8-sig")
    return parsed_toml(text, str(path), "give a scenario file")


def _changed(data: dict[str, Any], changes: Sequence[Override]) -> dict[str, Any]:
    for change in changes:
        put(data, change)
    return data


def _validate(model: type[Spec], data: dict[str, Any], where: str, changes: Sequence[Override]) -> Spec:
    """Validate as JSON: strict, so that no text counts as a number, yet with arrays and dates."""
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
    """Return the last override that affects the path, otherwise the file."""
    return next((change.where for change in reversed(changes) if change.touches(path)), where)
