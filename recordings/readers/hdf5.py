"""The data sets of numbers of an HDF5 file, found by its own links alone, and what they declare to hold."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from scenarios.errors import InputError

MOST_OBJECTS = 20_000
"""Links of a file that are followed; each takes some 50 us and some kilobytes."""
MOST_ATTRIBUTE, MOST_ATTRIBUTES = 100_000, 20_000_000
"""Bytes of an attribute that are read, text and a few numbers, and bytes of all attributes."""

INTERNAL = ("DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME")
"""Attributes by which HDF5 keeps the dimensions of its data sets."""


def data_sets(h5py: Any, file: Any, depth: int, where: str) -> Iterator[tuple[str, Any]]:
    """Yield (dotted name, data set of numbers) of a file, each object once however many links lead there.

    h5py : the library. depth : groups within each other that are entered.
    Links to other files, values stored in other files, and virtual data sets are left out.
    Raises InputError for more than MOST_OBJECTS links.
    """
    seen, waiting, left = set[int](), [("", file, 0)], MOST_OBJECTS
    while waiting:
        name, group, level = waiting.pop(0)
        for key in group:
            left -= 1
            if left < 0:
                raise InputError(f"holds more than {MOST_OBJECTS} objects", where=where, do="give a part of the log")
            item = _own(h5py, group, key, seen)
            full = f"{name}.{key}" if name else str(key)
            if isinstance(item, h5py.Dataset) and _is_plain(item):
                yield full, item
            elif isinstance(item, h5py.Group) and level < depth:
                waiting.append((full, item, level + 1))


def declared_bytes(item: Any) -> int:
    """Return the bytes that a data set declares as float64, or one of its chunks where that is more."""
    chunk = int(np.prod(item.chunks, dtype=np.float64)) if item.chunks else 0
    return 8 * max(int(np.prod(item.shape, dtype=np.float64)), chunk)


@dataclass
class Attributes:
    """The bytes of attributes that may still be read of a file; `where` is for messages."""

    where: str
    left: int = MOST_ATTRIBUTES

    def of(self, item: Any) -> dict[str, Any]:
        """Return the attributes of an object that are not large; InputError for more than MOST_ATTRIBUTES bytes."""
        found: dict[str, Any] = {}
        for name in item.attrs:
            if name not in INTERNAL and attribute_bytes(item.attrs, name) <= MOST_ATTRIBUTE:
                found[name] = item.attrs[name]
                self._spend(found[name])
        return found

    def _spend(self, value: Any) -> None:
        self.left -= sum(map(sys.getsizeof, value.ravel())) if isinstance(value, np.ndarray) else sys.getsizeof(value)
        if self.left < 0:
            what = f"its attributes hold more than {MOST_ATTRIBUTES / 1e6:.3g} MB"
            raise InputError(what, where=self.where, do="leave the attributes out")


def attribute_bytes(attributes: Any, name: str) -> int:
    """Return the bytes that an attribute takes in a file; text of any length counts as its reference alone."""
    kind = attributes.get_id(name)
    return int(kind.get_storage_size())


def _own(h5py: Any, group: Any, key: str, seen: set[int]) -> Any:
    """Return the object of a hard link that no other link led to; None for others."""
    if not isinstance(group.get(key, getlink=True), h5py.HardLink):
        return None
    address = int(h5py.h5o.get_info(group.id, key.encode()).addr)
    if address in seen:
        return None
    seen.add(address)
    return group[key]


def _is_plain(item: Any) -> bool:
    """Return whether a data set holds numbers, in this file."""
    return item.shape is not None and item.dtype.kind in "fiub" and item.external is None and not item.is_virtual
