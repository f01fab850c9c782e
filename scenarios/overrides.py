"""The option `--set key=value`: a value of a scenario, replaced by its dotted key."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from typing import Any

from scenarios.errors import InputError
from scenarios.nesting import is_nested_deep

MAX_LENGTH = 10_000
MAX_DEPTH = 20
"""Parts of a key; the deepest value of a scenario has six."""
_INDEX = re.compile(r"[0-9]{1,6}")
_BARE_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_.:/-]*")


@dataclass(frozen=True)
class Override:
    """An override: text, path in the scenario, and new value (None removes the key)."""

    text: str
    path: tuple[str | int, ...]
    value: Any

    @property
    def where(self) -> str:
        return f"--set {self.text}"

    def touches(self, path: tuple[str | int, ...]) -> bool:
        """Return whether an error at `path` can come from the override."""
        shared = min(len(path), len(self.path))
        return shared > 0 and path[:shared] == self.path[:shared]


def parse(text: str) -> Override:
    """Parse `key=value`: the value as TOML, a bare word as a string; an empty value removes the key.

    Raises InputError for a text without a key, and for a value that is neither TOML nor a word.
    """
    if len(text) > MAX_LENGTH:
        where, do = f"--set {text[:60]}…", "write the value into a scenario file"
        raise InputError(f"longer than {MAX_LENGTH} characters", where=where, do=do)
    key, equals, value = (part.strip() for part in text.partition("="))
    text = " ".join(text.split())  # messages stay on one line
    text = text if len(text) <= 200 else text[:200] + "…"
    path = _parse_key(key)
    if not equals or not path:
        raise InputError("not a dotted key and a value", where=f"--set {text}", do="write --set phases.0.radius_m=20")
    return Override(text, path, _parse_value(value, text) if value else None)


def _parse_key(key: str) -> tuple[str | int, ...]:
    """Return the parts of a dotted TOML key (parts may be quoted), numbers as indices; () for an invalid key."""
    if is_nested_deep(key):
        return ()
    try:
        table: Any = tomllib.loads(f"{key} = 0")
    except ValueError:
        return ()
    parts: list[str | int] = []
    while isinstance(table, dict):
        ((part, table),) = table.items()
        parts.append(int(part) if _INDEX.fullmatch(part) else part)
    return tuple(parts) if len(parts) <= MAX_DEPTH else ()


def _parse_value(value: str, text: str) -> Any:
    where, advice = f"--set {text}", 'numbers, true, "text", [1, 2, 3]'
    try:
        if is_nested_deep(f"value = {value}"):
            raise RecursionError
        table = tomllib.loads(f"value = {value}")
    except tomllib.TOMLDecodeError as error:
        if _BARE_WORD.fullmatch(value):
            return value
        raise InputError(f"the value is not TOML: {error}".split(" (at")[0], where=where, do=advice) from None
    except (RecursionError, ValueError):  # a number of thousands of digits
        raise InputError("the value is nested too deep, or a number too long", where=where, do=advice) from None
    if len(table) != 1:
        raise InputError("more than one value", where=where, do="give one --set for each key")
    return table["value"]


def put(data: dict[str, Any], override: Override) -> None:
    """Set the override's value in plain data, creating missing tables.

    Raises InputError for a path through a value or beyond the end of an array.
    """
    node: Any = data
    for depth, part in enumerate(override.path):
        done = ".".join(map(str, override.path[:depth]))
        _check_step(node, part, done, override)
        if depth == len(override.path) - 1:
            _store(node, part, override)
        elif isinstance(node, dict):
            node = node.setdefault(str(part), {})
        else:
            node = node[part]


def _check_step(node: Any, part: str | int, done: str, override: Override) -> None:
    if isinstance(node, list):
        if not isinstance(part, int) or part >= len(node):
            do = f"its entries are 0 to {len(node) - 1}" if node else "it is empty"
            raise InputError(f"{done} is an array and has no entry {part}", where=override.where, do=do)
    elif not isinstance(node, dict):
        raise InputError(f"{done} is a value and has no key {part}", where=override.where, do=f"set {done} itself")


def _store(node: Any, part: str | int, override: Override) -> None:
    key = part if isinstance(node, list) else str(part)
    if override.value is not None:
        node[key] = override.value
    elif isinstance(node, dict) and key in node:
        del node[key]
    else:
        do = "an empty value removes a key of a table; give a value"
        raise InputError("there is nothing to remove", where=override.where, do=do)
