"""Where the messages of a DataFlash log begin, and how each type is laid out, without reading message by message.

A message is A3 95, its type in one byte, and its values. Messages of type 80 (FMT) give type, length in bytes, name,
format (a character a value) and the names of the values of every type [ArduPilot: AP_Logger/LogStructure.h].
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array

Bytes = NDArray[np.uint8]
Starts = NDArray[np.int64]
HEAD = (0xA3, 0x95)
FMT, FMT_LENGTH = 0x80, 89
MARK = bytes((*HEAD, FMT))
"""The first bytes of a log: the message that lays out the layouts."""
CODES = {
    **{"a": "(32,)<i2", "b": "i1", "B": "u1", "h": "<i2", "H": "<u2", "i": "<i4", "I": "<u4", "f": "<f4", "d": "<f8"},
    **{"n": "S4", "N": "S16", "Z": "S64", "c": "<i2", "C": "<u2", "e": "<i4", "E": "<u4", "L": "<i4", "M": "u1"},
    **{"q": "<i8", "Q": "<u8", "g": "<f2"},
}
"""numpy's type of each format character."""
SCALES = {"c": 1e-2, "C": 1e-2, "e": 1e-2, "E": 1e-2, "L": 1e-7}
"""The unit of one count, for the characters of fixed-point numbers."""
BLOCK = 1 << 22
"""Bytes that are searched for messages at a time."""
MOST_DEFINITIONS = 1 << 14
"""Messages of layouts that are looked at: logs hold some hundreds."""
_NAME, _LABEL = re.compile(r"\w{1,4}", re.ASCII), re.compile(r"\w+", re.ASCII)


@dataclass(frozen=True, eq=False)
class MessageLayout:
    """A message type.

    Parameters
    ----------
    name : of the type, up to four characters. length : of a message in bytes, with its head of three.
    kinds : by the name of a value, its format character. dtype : numpy's type of a whole message.
    """

    name: str
    length: int
    kinds: dict[str, str]
    dtype: np.dtype[np.void]


def layouts_of(data: Bytes) -> dict[int, MessageLayout]:
    """Return the layout of every type that a log defines, by its number; the first of two definitions counts."""
    found: dict[int, MessageLayout] = {}
    starts = (start for heads in _heads(data) for start in heads[data[heads + 2] == FMT].tolist())
    for start in itertools.islice(starts, MOST_DEFINITIONS):
        body = data[start + 3 : start + FMT_LENGTH].tobytes()
        if len(body) == FMT_LENGTH - 3 and body[0] not in found and (layout := _layout(body)):
            found[body[0]] = layout
    return found


def message_starts(data: Bytes, layouts: dict[int, MessageLayout]) -> tuple[dict[int, Starts], int]:
    """Return where the whole messages of each type begin, and how many bytes belong to no message.

    A message follows where the last ends; after bytes that are no message, the next head of a known type counts.
    """
    lengths = np.zeros(256, np.int64)
    lengths[list(layouts)] = [layout.length for layout in layouts.values()]
    found, end = [np.zeros(0, np.int64)], 0
    for heads in _heads(data):
        spans = lengths[data[heads + 2]]
        kept = (spans > 0) & (heads >= end) & (heads + spans <= len(data))
        heads, ends = heads[kept], (heads + spans)[kept]
        reached = _chain(np.searchsorted(heads, ends))
        found.append(heads[reached])
        end = int(ends[reached][-1]) if len(ends) else end
    starts = np.concatenate(found)
    found.clear()  # the places of a large log count
    types = data[starts + 2]
    return {number: starts[types == number] for number in layouts}, len(data) - int(np.sum(lengths[types]))


def _heads(data: Bytes) -> Iterator[Starts]:
    """Yield where HEAD stands before a further byte, block by block."""
    for first in range(0, len(data), BLOCK):
        block = data[first : first + BLOCK + 2]
        yield first + np.flatnonzero((block[:-2] == HEAD[0]) & (block[1:-1] == HEAD[1]))


def _chain(following: Starts) -> NDArray[np.bool_]:
    """Return which of n places are reached from the first, where `following` (n,) gives the place after each."""
    steps, reached, place = following.tolist(), bytearray(len(following)), 0
    while place < len(steps):
        reached[place] = 1
        place = steps[place]
    return np.frombuffer(reached, np.bool_)


def _layout(body: bytes) -> MessageLayout | None:
    """Return the layout that the 86 bytes of an FMT message give; None where they contradict themselves."""
    name, kinds, labels = (_text(part) for part in (body[2:6], body[6:22], body[22:]))
    if not _NAME.fullmatch(name) or not set(kinds) <= set(CODES):
        return None
    names = [label.strip() for label in labels.split(",")][: len(kinds)]
    codes = [np.dtype(CODES[kind]) for kind in kinds]
    ends = 3 + np.cumsum([code.itemsize for code in codes], dtype=np.int64)
    if not _are_labels(names, len(kinds)) or ends[-1] > body[1]:
        return None
    offsets = [int(end) - code.itemsize for end, code in zip(ends, codes, strict=True)]
    dtype = np.dtype({"names": names, "formats": codes, "offsets": offsets, "itemsize": body[1]})
    return MessageLayout(name, body[1], dict(zip(names, kinds, strict=True)), dtype)


def _are_labels(names: Sequence[str], count: int) -> bool:
    """Whether there is a name for each of `count` values, each once, and at least one value."""
    return count > 0 and len(set(names)) == count and all(map(_LABEL.fullmatch, names))


def _text(part: bytes) -> str:
    return part.split(b"\0", 1)[0].decode("ascii", "replace")


def scaled(values: NDArray[np.generic], kind: str) -> Array:
    """Return values of a format character as float64, fixed-point numbers in their unit."""
    return values.astype(np.float64) * SCALES.get(kind, 1.0)
