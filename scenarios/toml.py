"""Scenarios as plain data and as TOML text (the standard library reads TOML but does not write it)."""

from __future__ import annotations

import datetime
import hashlib
import json
import math
import re
from typing import Any

from pydantic import BaseModel

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def as_dict(scenario: BaseModel) -> dict[str, Any]:
    """Everything that the scenario says, defaults included, in JSON's types and under the files' keys."""
    return scenario.model_dump(mode="json", by_alias=True, exclude_none=True)


def digest(scenario: BaseModel) -> str:
    """SHA-256 (hex) of the scenario's canonical JSON: equal exactly when the scenarios are equal."""
    text = json.dumps(as_dict(scenario), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def to_toml(scenario: BaseModel) -> str:
    """A scenario (or model) file that loads back equal; values at their defaults are left out."""
    return dumps(scenario.model_dump(by_alias=True, exclude_none=True, exclude_defaults=True))


def dumps(table: dict[str, Any]) -> str:
    """TOML text of a table: plain values first, then its tables and arrays of tables."""
    return "\n".join(_lines(table, ())).strip("\n") + "\n"


def _lines(table: dict[str, Any], path: tuple[str, ...]) -> list[str]:
    nested = {key: value for key, value in table.items() if isinstance(value, dict) or _is_array_of_tables(value)}
    lines = [f"{_key(key)} = {_value(value)}" for key, value in table.items() if key not in nested]
    for key, value in nested.items():
        name = ".".join(map(_key, (*path, key)))
        if isinstance(value, dict):
            inner = _lines(value, (*path, key))
            only_tables = bool(value) and inner[0] == ""  # its own header would be empty
            lines += inner if only_tables else ["", f"[{name}]", *inner]
        else:
            for item in value:
                lines += ["", f"[[{name}]]", *_lines(item, (*path, key))]
    return lines


def _is_array_of_tables(value: Any) -> bool:
    return isinstance(value, list | tuple) and bool(value) and all(isinstance(item, dict) for item in value)


def _key(key: str) -> str:
    return key if _BARE_KEY.fullmatch(key) else _string(key)


def _string(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, float) and not math.isfinite(value):
        return "nan" if math.isnan(value) else f"{value:f}"
    if isinstance(value, datetime.date | datetime.time):
        return value.isoformat()
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(key)} = {_value(item)}" for key, item in value.items()) + "}"
    return repr(value)
