"""The keys of a result as its JSON Schema says: a table of the page for each table of the result."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

Schema = Mapping[str, Any]
WORDS = {"number": "number", "integer": "whole number", "string": "text", "boolean": "true or false", "object": "table"}
WORDS |= {"null": "null"}
SEVERAL = {"number": "numbers", "whole number": "whole numbers", "text": "texts", "table": "tables"}
NAME = "NAME"
"""Stands for a key that is a name, such as a calibrator's."""
PARTS = re.compile(r"[A-Z][a-z]*")


@dataclass(frozen=True)
class KeyTable:
    """A table of a result: `paths` where it stands, such as `effects[]`, and a row (key, value, meaning) each key."""

    name: str
    says: str
    rows: tuple[tuple[str, str, str], ...]
    paths: list[str] = field(default_factory=list)


def tables(schema: Schema) -> list[KeyTable]:
    """The result's own table, then the inner ones in the order of their first appearance."""
    found: dict[str, KeyTable] = {}
    waiting = deque([("", "", schema)])
    while waiting:
        name, path, table = waiting.popleft()
        new = name not in found
        if new:
            found[name] = KeyTable(name, str(table.get("description", "")), tuple(_rows(table)))
        if path not in found[name].paths:
            found[name].paths.append(path)
        if new:
            inner = (one for key, value in _keys(table).items() for one in _inner(value, f"{path}.{key}".strip(".")))
            waiting.extend((name, path, schema["$defs"][name]) for name, path in inner)
    return list(found.values())


def words(name: str) -> str:
    """A table's name as words: `NamedEffectJson` is a named effect."""
    return " ".join(PARTS.findall(name.removesuffix("Json"))).lower()


def _keys(table: Schema) -> dict[str, Schema]:
    """The declared keys, and NAME where any further key may stand."""
    named = _named(table)
    return dict(table.get("properties", {})) | ({NAME: named} if named else {})


def _named(table: Schema) -> Schema:
    """What stands under names that are not declared; empty where there are none, or anything may stand there."""
    values = table.get("additionalProperties")
    return values if isinstance(values, Mapping) else {}


def _rows(table: Schema) -> Iterator[tuple[str, str, str]]:
    for name, value in _keys(table).items():
        optional = name not in table.get("required", ()) and name != NAME
        kind = _kind(value).removesuffix(" or null") + "; may be left out" if optional else _kind(value)
        yield name, kind, str(value.get("description", ""))


def _inner(value: Schema, path: str) -> Iterator[tuple[str, str]]:
    """Names and paths of the tables in a value."""
    if "$ref" in value:
        yield value["$ref"].rsplit("/", 1)[1], path
    for one in value.get("anyOf", ()):
        yield from _inner(one, path)
    if value.get("items"):
        yield from _inner(value["items"], f"{path}[]")
    if _named(value):
        yield from _inner(_named(value), f"{path}.{NAME}")


def _kind(value: Schema) -> str:
    """What a value is, in words; an inner table by its name in brackets."""
    if "anyOf" in value:
        return " or ".join(dict.fromkeys(map(_kind, value["anyOf"])))
    if "$ref" in value:
        return f"[{words(value['$ref'].rsplit('/', 1)[1])}]"
    if "enum" in value:
        return ", ".join(map(str, value["enum"]))
    match value.get("type"):
        case "array":
            return _list(value)
        case "object" if _named(value):
            return f"table of {_several(_named(value))} by name"
    return WORDS.get(value.get("type", ""), "any")


def _list(value: Schema) -> str:
    count, inner = value.get("minItems"), _several(value.get("items", {}))
    if count is None or count != value.get("maxItems"):
        return f"list of {inner}" if inner != "any" else "list"
    return f"{count} × {inner}" if inner.endswith(" numbers") else f"{count} {inner}"


def _several(item: Schema) -> str:
    kind = _kind(item).removesuffix(" or null")
    return SEVERAL.get(kind, kind)
