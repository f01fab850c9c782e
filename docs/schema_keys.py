"""The keys of a scenario's tables, as their schema says: the rows of tables in docs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

TYPES = {
    "Effects": "tables",
    "float": "number",
    "int": "whole number",
    "str": "text",
    "date": "date",
    "bool": "true or false",
}


def rows(model: type[BaseModel]) -> Iterable[tuple[str, ...]]:
    """A row a key: its name, kind, default, range and meaning."""
    for name, info in model.model_fields.items():
        if name not in ("kind", "name", "summary", "field", "vehicle", "phases"):
            yield (f"`{info.alias or name}`", _kind(info.annotation), _default(info), _range(info), meaning(info))


def _kind(annotation: Any) -> str:
    if get_origin(annotation) is Annotated:
        return _kind(get_args(annotation)[0])
    if get_origin(annotation) is Literal:
        return ", ".join(f'"{word}"' for word in get_args(annotation))
    parts = [part for part in get_args(annotation) if part is not type(None)]
    if get_origin(annotation) is tuple:
        return {"number": f"{len(parts)} numbers", "text": "list of names"}.get(_kind(parts[0]), "array of tables")
    if get_origin(annotation) is dict:
        return "tables"
    if parts:
        return _kind(parts[0])
    return TYPES.get(annotation.__name__, "table")


def _default(info: FieldInfo) -> str:
    if info.is_required():
        return "required"
    value = info.default
    if value is None or not isinstance(value, int | float | str | tuple) or isinstance(value, BaseModel):
        return "–"
    if isinstance(value, tuple):
        return ", ".join(f"{v:g}" if isinstance(v, float) else str(v) for v in value if isinstance(v, float | str))
    return f"{value:.7g}" if isinstance(value, float) else str(value)


def _range(info: FieldInfo) -> str:
    signs = {"ge": "≥", "gt": ">", "le": "≤", "lt": "<"}
    found = [
        f"{sign} {getattr(rule, key):g}" for rule in info.metadata for key, sign in signs.items() if hasattr(rule, key)
    ]
    return ", ".join(found) or "–"


def meaning(info: FieldInfo) -> str:
    """What it is, as the schema says."""
    return info.description or ""
