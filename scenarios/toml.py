"""Scenarios as plain data and as TOML text."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from pydantic import BaseModel


def as_dict(scenario: BaseModel) -> dict[str, Any]:
    """Everything that the scenario says, defaults included, in JSON's types and under the files' keys."""
    return scenario.model_dump(mode="json", by_alias=True, exclude_none=True)


def digest(scenario: BaseModel) -> str:
    """SHA-256 (hex) of the scenario's canonical JSON: equal exactly when the scenarios are equal."""
    text = json.dumps(as_dict(scenario), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def to_toml(scenario: BaseModel) -> str:
    """A scenario (or model) file that loads back equal; values at their defaults are left out."""
    import tomlkit  # here: most commands read scenarios and write none

    return str(tomlkit.dumps(scenario.model_dump(by_alias=True, exclude_none=True, exclude_defaults=True)))
