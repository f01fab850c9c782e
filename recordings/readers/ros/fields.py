"""The numbers of a ROS message by path: which fields a type has, and how a message becomes a row."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import attrgetter
from typing import Any

import numpy as np

from scenarios.arrays import Array

NUMBERS = frozenset(
    (
        *("bool", "byte", "char", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64"),
        *("float32", "float64"),
    )
)
LARGEST_ARRAY = 36
"""Members of the largest fixed array that is read: the covariance of a pose."""
MOST_MEMBERS = 32
"""Members of a sequence that are read: motors, cells, radio channels."""
DEEPEST = 8
"""Levels of a type within a type."""
BASE, NAME, ARRAY, SEQUENCE = 1, 2, 3, 4
"""Kinds of a field in the library's description of a type."""
HEADER = "std_msgs/msg/Header"
Definitions = Mapping[str, Any]


@dataclass(frozen=True)
class Layout:
    """The fields of a message type by path, as "pose.pose.position.x".

    Parameters
    ----------
    numbers : paths of numbers. words : of texts, outside the header.
    arrays : path -> number of members of a fixed array of numbers.
    sequences : paths of sequences of numbers, or of messages: path -> the paths of the numbers within a member.
    stamped : whether the message has a header.
    """

    numbers: tuple[str, ...] = ()
    words: tuple[str, ...] = ()
    arrays: tuple[tuple[str, int], ...] = ()
    sequences: tuple[tuple[str, tuple[str, ...]], ...] = ()
    stamped: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """The columns of numbers that every message of the type has."""
        return (*self.numbers, *(f"{path}[{k}]" for path, size in self.arrays for k in range(size)))

    def getter(self) -> Callable[[Any], tuple[Any, ...]]:
        """Return the function that gives the fields of a message: numbers, then arrays, then sequences."""
        paths = (*self.numbers, *(path for path, _ in self.arrays), *(path for path, _ in self.sequences))
        if not paths:
            return lambda message: ()
        get: Callable[[Any], Any] = attrgetter(*paths)
        return get if len(paths) > 1 else lambda message: (get(message),)

    def block(self, rows: Sequence[tuple[Any, ...]]) -> Array:
        """Return messages as (n, k): numbers, arrays, then MOST_MEMBERS places for each number of a sequence."""
        columns, numbers, arrays = list(zip(*rows, strict=True)), len(self.numbers), len(self.arrays)
        parts = [np.array(columns[:numbers], np.float64).reshape(numbers, len(rows)).T]
        for values in columns[numbers : numbers + arrays]:
            parts.append(np.array(values, np.float64).reshape(len(rows), -1))
        for (_, paths), members in zip(self.sequences, columns[numbers + arrays :], strict=True):
            parts.append(_padded(members, paths))
        return np.concatenate(parts, axis=1)

    def joined(self, blocks: Sequence[Array]) -> tuple[list[str], Array]:
        """Return the names and values (n, k) of all columns, without the places that no sequence fills."""
        names = list(self.names)
        for path, paths in self.sequences:
            own = [f".{inner}" for inner in paths] or [""]
            names += [f"{path}[{k}]{inner}" for k in range(MOST_MEMBERS) for inner in own]
        values = np.concatenate(blocks) if blocks else np.empty((0, len(names)))
        used = np.array([k < len(self.names) or bool(np.isfinite(values[:, k]).any()) for k in range(len(names))], bool)
        return [name for name, there in zip(names, used, strict=True) if there], values[:, used]


def _padded(values: Sequence[Any], paths: tuple[str, ...]) -> Array:
    """Return sequences as (n, MOST_MEMBERS times the numbers of a member), NaN beyond their ends."""
    width = max(1, len(paths))
    found = np.full((len(values), MOST_MEMBERS * width), np.nan)
    get = [attrgetter(path) for path in paths]
    for row, members in enumerate(values):
        some = members[:MOST_MEMBERS]
        flat = [one(member) for member in some for one in get] if get else some
        found[row, : len(flat)] = flat
    return found


def needed_types(definitions: Definitions, kinds: Iterable[str]) -> dict[str, Any]:
    """Return the definitions of some types and of all types within; types that are not defined are left out."""
    found: dict[str, Any] = {}
    queue = list(kinds)
    while queue:
        kind = queue.pop()
        if kind in definitions and kind not in found:
            found[kind] = definitions[kind]
            queue += [inner for _, one in found[kind][1] if (inner := _inner(one)) is not None]
    return found


def _inner(description: Any) -> str | None:
    """Return the type of a field that is a message, or holds messages."""
    node, what = int(description[0]), description[1]
    if node in (ARRAY, SEQUENCE):
        node, what = int(what[0][0]), what[0][1]
    return str(what) if node == NAME else None


def layout_of(definitions: Definitions, kind: str) -> Layout | None:
    """Return the fields of a message type, None for a type that is not defined."""
    return _layout(definitions, kind, 0)


def _layout(definitions: Definitions, kind: str, depth: int) -> Layout | None:
    if kind not in definitions or depth > DEEPEST:
        return None
    parts = [_field(definitions, name, one, depth) for name, one in definitions[kind][1]]
    found = [part for part in parts if part is not None]
    return reduce(_sum, found, Layout()) if len(found) == len(parts) else None


def _sum(one: Layout, other: Layout) -> Layout:
    return Layout(
        one.numbers + other.numbers,
        one.words + other.words,
        one.arrays + other.arrays,
        one.sequences + other.sequences,
        one.stamped or other.stamped,
    )


def _field(definitions: Definitions, name: str, description: Any, depth: int) -> Layout | None:
    """Return the layout of a field; None where a type within is not defined."""
    node, what = int(description[0]), description[1]
    if node == BASE:
        number, word = what[0] in NUMBERS, what[0] == "string"
        return Layout(numbers=(name,) if number else (), words=(name,) if word else ())
    if node == NAME:
        return _nested(definitions, name, what, depth)
    (inner, kind), size = what
    if int(inner) == BASE:
        return _members(name, kind[0], size if node == ARRAY else 0)
    members = _layout(definitions, kind, depth + 1)
    return members and Layout(sequences=((name, members.numbers),))


def _nested(definitions: Definitions, name: str, kind: str, depth: int) -> Layout | None:
    if kind == HEADER:
        return Layout(stamped=name == "header" and depth == 0)
    inner = _layout(definitions, kind, depth + 1)
    return inner and Layout(
        tuple(f"{name}.{path}" for path in inner.numbers),
        tuple(f"{name}.{path}" for path in inner.words),
        tuple((f"{name}.{path}", size) for path, size in inner.arrays),
        tuple((f"{name}.{path}", paths) for path, paths in inner.sequences),
    )


def _members(name: str, kind: str, size: int) -> Layout:
    """Return the layout of an array or a sequence of numbers or texts; large arrays have none."""
    if kind not in NUMBERS:
        return Layout()
    if size:
        return Layout(arrays=((name, size),) if size <= LARGEST_ARRAY else ())
    return Layout(sequences=((name, ()),))
