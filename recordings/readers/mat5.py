"""The elements of a MATLAB file of version 5 to 7, each bounded by the element that holds it.

A reader of this project's own: scipy's follows the types and sizes of a damaged file out of its memory, and takes the
process down. Format: MathWorks, MAT-File Format, version 5: an element is a type (4 bytes), a size (4 bytes) and data
padded to 8 bytes; up to 4 bytes of data may stand in the place of the padding, with type and size in 2 bytes each.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

HEADER = 128
TYPES = {
    **{1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4"},
    **{6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"},
}
"""numpy's types by the number of an element's type."""
MATRIX, COMPRESSED = 14, 15
CELL, STRUCT, NUMERIC = 1, 2, range(6, 16)
"""Classes of a matrix: cells, a struct; double, single and whole numbers."""
MOST_WIDE = 30
"""Numbers of a member of an array of structs that becomes a row."""
COMPLEX = 0x800
MOST_FIELDS = 10_000
MOST_ELEMENTS = 300_000
"""Elements of a file that are looked at, of some 5 us each; an array takes five."""
MOST_DEPTH = 6
"""Levels of structs within structs that are read."""
Found = dict[str, NDArray[Any]]


class DamagedMatError(Exception):
    """A MATLAB file whose elements contradict each other, or are larger than what is read."""


@dataclass
class ElementCount:
    """The elements of a file that may still be looked at."""

    left: int = MOST_ELEMENTS

    def spend(self) -> None:
        """Count an element; DamagedMatError for more than MOST_ELEMENTS."""
        self.left -= 1
        if self.left < 0:
            raise DamagedMatError(f"it has more than {MOST_ELEMENTS} elements")


@dataclass(frozen=True)
class Element:
    """An element's type, its data in the byte order of the file, "<" or ">", and the count of the file's elements."""

    kind: int
    data: memoryview
    order: str
    count: ElementCount = field(default_factory=ElementCount)

    def within(self, plain: bytes) -> Element:
        """Return the decompressed data of an element as one that holds elements."""
        return Element(0, memoryview(plain), self.order, self.count)

    def numbers(self) -> NDArray[Any]:
        """Return the data of an element of numbers (n,)."""
        if self.kind not in TYPES:
            raise DamagedMatError(f"an element of type {self.kind} stands for numbers")
        kind = np.dtype(self.order + TYPES[self.kind])
        return np.frombuffer(self.data[: len(self.data) // kind.itemsize * kind.itemsize], kind)

    def parts(self) -> Iterator[Element]:
        """Yield the elements within."""
        at, size = 0, len(self.data)
        while at + 8 <= size:
            self.count.spend()
            first, second = np.frombuffer(self.data[at : at + 8], f"{self.order}u4").tolist()
            small = first >> 16
            kind, length, begin = (first & 0xFFFF, small, at + 4) if small else (first, second, at + 8)
            if begin + length > size or small > 4:
                raise DamagedMatError("an element ends beyond the data that hold it")
            yield Element(kind, self.data[begin : begin + length], self.order, self.count)
            at = at + 8 if small else begin + (length if kind == COMPRESSED else -(-length // 8) * 8)


def arrays_of(data: bytes, most: int) -> Found:
    """Return the arrays of numbers of a file by their names, fields of structs behind dots.

    The fields of an array of structs become a row a struct, cells of single numbers a matrix; other cells are numbered.
    Sparse and complex matrices, words and objects are left out.
    Raises DamagedMatError for what contradicts itself, and for more than `most` bytes, decompressed.
    """
    order = "<" if data[126:128] == b"IM" else ">"
    found, size = Found(), 0
    for part in Element(0, memoryview(data)[HEADER:], order).parts():
        if part.kind == COMPRESSED:
            plain = inflated(bytes(part.data), most, size)
            size += len(plain)
            for inner in part.within(plain).parts():
                found |= _matrix("", inner, 0)
        else:
            found |= _matrix("", part, 0)
    return found


def inflated(data: bytes, most: int, size: int = 0) -> bytes:
    """Return zlib's stream decompressed; DamagedMatError for another stream, and for more than `most` bytes.

    size : of the streams of the same file that were decompressed before.
    """
    stream, parts, rest = zlib.decompressobj(), [], data
    try:
        while rest and not stream.eof:
            parts.append(stream.decompress(rest, 1 << 24))
            size += len(parts[-1])
            if size > most:
                raise DamagedMatError(f"more than {most} bytes are compressed in it")
            rest = stream.unconsumed_tail
    except zlib.error as error:
        raise DamagedMatError("an element cannot be decompressed") from error
    return b"".join(parts)


def _matrix(name: str, element: Element, depth: int) -> Found:
    """Return the arrays in a matrix: itself, or the fields of a struct. `name` is that of the struct around."""
    parts = list(islice(element.parts(), 4 + MOST_ELEMENTS)) if element.kind == MATRIX else []
    if len(parts) < 4 or depth > MOST_DEPTH:
        return {}
    flags, shape = int(parts[0].numbers()[:1].sum()), tuple(parts[1].numbers().tolist())
    own = parts[2].data.tobytes().decode("latin-1").strip("\0")
    full = ".".join(part for part in (name, own) if part)
    return _content(full, flags, shape, parts[3:], depth)


def _content(name: str, flags: int, shape: tuple[int, ...], parts: list[Element], depth: int) -> Found:
    """Return a matrix of numbers in its shape, the fields of structs, or what cells hold."""
    values = int(np.prod(shape, dtype=np.float64))
    if flags & 0xFF == STRUCT and len(parts) > 1:
        return _fields(name, parts, values, depth)
    if flags & 0xFF == CELL and 0 < values <= len(parts):
        return _cells(name, parts[:values], shape, depth)
    if flags & 0xFF not in NUMERIC or flags & COMPLEX:
        return {}
    numbers = parts[0].numbers()
    if min(shape, default=0) < 0 or values != len(numbers):
        raise DamagedMatError("a matrix has other numbers than its shape")
    return {name: numbers.reshape(shape, order="F")}


def _fields(name: str, parts: list[Element], structs: int, depth: int) -> Found:
    """Return the fields of structs: the length of a field's name, the names, then a matrix a field of each struct."""
    length = int(parts[0].numbers()[:1].sum())
    text = parts[1].data.tobytes()
    if not 0 < length <= len(text) or len(text) // length > MOST_FIELDS:
        return {}
    names = [text[k : k + length].split(b"\0")[0].decode("latin-1") for k in range(0, len(text), length)]
    found: Found = {}
    for k, key in enumerate(names):
        members = parts[2 + k :: len(names)][:structs]
        new = _matrix(f"{name}.{key}", members[0], depth + 1) if structs == 1 and members else {}
        found |= new if structs == 1 else _stacked(f"{name}.{key}", members, depth)
    return found


def _stacked(name: str, members: list[Element], depth: int) -> Found:
    """Return matrices of one size as rows (n, k) of one array; nothing where one is no small matrix of numbers."""
    rows = [_matrix("", one, depth + 1).get("", np.array([])).ravel() for one in members]
    width = len(rows[0]) if rows else 0
    if not 0 < width <= MOST_WIDE or any(len(row) != width for row in rows):
        return {}
    return {name: np.array(rows, np.float64).reshape(len(rows), -1).squeeze(axis=-1 if width == 1 else ())}


def _cells(name: str, parts: list[Element], shape: tuple[int, ...], depth: int) -> Found:
    """Return cells of single numbers as a matrix, others as `name_1` and so on."""
    single = _stacked(name, parts, depth)
    if single and single[name].ndim == 1:
        return {name: single[name].reshape(shape, order="F")}
    found: Found = {}
    for k, one in enumerate(parts[:MOST_FIELDS], 1):
        found |= _matrix(f"{name}_{k}", one, depth + 1)
    return found
