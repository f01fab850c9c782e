"""JSON Schema of scenario files, for editors."""

from __future__ import annotations

from typing import Any

from scenarios.spec import Scenario

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def json_schema(effects: dict[str, dict[str, Any]] | None = None) -> dict[str, Any]:
    """JSON Schema (2020-12) of a scenario file.

    `effects`: schema of each effect's table by name; then other names are refused, and each effect may be a table or an
    array of tables, of the scenario and of each sensor.
    """
    schema = {"$schema": DIALECT, **Scenario.model_json_schema(by_alias=True)}
    if effects is not None:
        definitions = schema["$defs"]
        definitions["Effects"] = _tables(effects)
        for owner in (schema, definitions["SensorSpec"]):
            shown = {k: v for k, v in owner["properties"]["effects"].items() if k in ("description", "title")}
            owner["properties"]["effects"] = {**shown, "$ref": "#/$defs/Effects"}
    return schema


def _tables(effects: dict[str, dict[str, Any]]) -> dict[str, Any]:
    either = {
        name: {"anyOf": [table, {"type": "array", "items": table, "minItems": 1}]} for name, table in effects.items()
    }
    return {"type": "object", "properties": either, "additionalProperties": False}
