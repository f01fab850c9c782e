"""ULog's message formats: the fields of a topic, nested formats flattened, as the layout of its bytes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

TYPES = {
    **{f"int{bits}_t": f"<i{bits // 8}" for bits in (8, 16, 32, 64)},
    **{f"uint{bits}_t": f"<u{bits // 8}" for bits in (8, 16, 32, 64)},
    **{"float": "<f4", "double": "<f8", "bool": "<u1", "char": "<i1"},
}
"""The basic types as numpy's, little-endian; the last character is the number of bytes."""
MOST_FIELDS = 4096
"""A topic with more fields is not read: PX4's largest has some 150, while a hostile file's nested arrays multiply."""
MOST_NESTED = 8
"""Formats within formats beyond which a topic is not read; a format may name itself."""
PADDING = "_padding"
Field = tuple[str, int, str]


@dataclass(frozen=True)
class TopicLayout:
    """The bytes of a topic's message.

    Parameters
    ----------
    dtype : the numeric fields at their offsets, under names like `q[0]` and `esc[2].esc_rpm`.
    size : bytes without the padding at the end, which a message may leave out. padded : with this padding.
    """

    dtype: np.dtype[Any]
    size: int
    padded: int


class UnreadableFormatError(ValueError):
    """A topic whose format is missing, damaged or beyond the limits."""


def layout_of(topic: str, formats: Mapping[str, str]) -> TopicLayout:
    """Return the layout of a topic's message; UnreadableFormatError for a topic without a usable format.

    formats : by name, their text `type field;type[length] field;`, in which a type may be another format's name.
    """
    fields = list(_flat("", topic, _Fields(formats), MOST_NESTED))
    names = {name for name, _ in fields}
    if ("timestamp", "uint64_t") not in fields or len(names) < len(fields):
        raise UnreadableFormatError(topic)
    ends = np.cumsum([_bytes(kind) for _, kind in fields]).tolist()
    size = max(end for (name, _), end in zip(fields, ends, strict=True) if not name.startswith(PADDING))
    return TopicLayout(_dtype(fields, ends, size), size, ends[-1])


def _dtype(fields: Sequence[tuple[str, str]], ends: Sequence[int], size: int) -> np.dtype[Any]:
    """Return the numeric fields (name, type) that end at these bytes of a message."""
    used = [
        (name, kind, end - _bytes(kind))
        for (name, kind), end in zip(fields, ends, strict=True)
        if kind != "char" and PADDING not in name
    ]
    names, kinds, offsets = zip(*used, strict=True)
    spec = {"names": names, "formats": [TYPES[kind] for kind in kinds], "offsets": offsets, "itemsize": size}
    return np.dtype(spec)  # type: ignore[call-overload,no-any-return]


class _Fields(dict[str, tuple[Field, ...]]):
    """The fields (type, length, name) of formats by name, parsed when first used; length 0 is no array."""

    def __init__(self, formats: Mapping[str, str]) -> None:
        super().__init__()
        self.formats = formats
        self.steps = 0

    def step(self) -> None:
        """Count a field, nested formats too; UnreadableFormatError beyond MOST_FIELDS."""
        self.steps += 1
        if self.steps > MOST_FIELDS:
            raise UnreadableFormatError("too many fields")

    def __missing__(self, name: str) -> tuple[Field, ...]:
        if name not in self.formats:
            raise UnreadableFormatError(name)
        self[name] = tuple(_field(one) for one in self.formats[name].split(";") if one)
        return self[name]


def _field(text: str) -> Field:
    words = text.split(" ")
    kind, bracket, length = words[0].partition("[")
    count = length.removesuffix("]")
    if len(words) != 2 or (bracket and not (count.isdecimal() and count.isascii() and len(count) < 6)):
        raise UnreadableFormatError(text)
    return kind, int(count) if bracket else 0, words[1]


def _flat(prefix: str, topic: str, formats: _Fields, depth: int) -> Iterator[tuple[str, str]]:
    """Yield (name, basic type) of each field, nested formats as `outer.inner` and arrays as `name[k]`."""
    if not depth:
        raise UnreadableFormatError(topic)
    for kind, length, name in formats[topic]:
        for one in (f"{prefix}{name}[{k}]" for k in range(length)) if length else (prefix + name,):
            formats.step()
            if kind in TYPES:
                yield one, kind
            else:
                yield from _flat(f"{one}.", kind, formats, depth - 1)


def _bytes(kind: str) -> int:
    return int(TYPES[kind][-1])
