"""Scenarios as plain data and as TOML text."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel


def as_dict(scenario: BaseModel) -> dict[str, Any]:
    """Return all values of a scenario, defaults included, in JSON's types and under the files' keys."""
    return scenario.model_dump(mode="json", by_alias=True, exclude_none=True)


def to_toml(scenario: BaseModel) -> str:
    """Return the text of a scenario (or model) file that loads back equal, without values at their defaults."""
    import tomlkit  # here: most commands read scenarios and write none

    return str(tomlkit.dumps(scenario.model_dump(by_alias=True, exclude_none=True, exclude_defaults=True)))
