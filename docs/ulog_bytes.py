"""ULog files laid out byte by byte [docs.px4.io, ULog File Format], for tests of the reader."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

MAGIC = bytes([0x55, 0x4C, 0x6F, 0x67, 0x01, 0x12, 0x35])
SYNC = bytes([0x2F, 0x73, 0x13, 0x20, 0x25, 0x0C, 0xBB, 0x12])
CODES = {
    **{"uint64_t": "Q", "int64_t": "q", "uint32_t": "I", "int32_t": "i", "uint16_t": "H", "int16_t": "h"},
    **{"uint8_t": "B", "int8_t": "b", "bool": "B", "float": "f", "double": "d"},
}
Value = tuple[str, Any]


@dataclass
class TopicOf:
    """A topic's samples: times in s, and fields name -> (type, values (n,) or (n, k))."""

    name: str
    time_s: Sequence[float] | np.ndarray
    fields: Mapping[str, Value]
    instance: int = 0
    padding: int = 0


@dataclass
class UlogOf:
    """What a file is to hold; changes : (time in s, name, value) of parameters within the log."""

    topics: Sequence[TopicOf]
    parameters: Mapping[str, float] = field(default_factory=dict)
    changes: Sequence[tuple[float, str, float]] = ()
    release: tuple[int, int, int] | None = None

    def bytes(self) -> bytes:
        """Return the file."""
        data = [struct.pack("<7sBQ", MAGIC, 1, 0), message("B", bytes(40))]
        formats = {topic.name: topic for topic in self.topics}
        data += [message("F", f"{name}:{_fields(topic)}".encode()) for name, topic in formats.items()]
        if self.release:
            code = (self.release[0] << 24) | (self.release[1] << 16) | (self.release[2] << 8) | 255
            data.append(message("I", _key("uint32_t ver_sw_release") + struct.pack("<I", code)))
        data += [parameter(name, value) for name, value in self.parameters.items()]
        for number, topic in enumerate(self.topics):
            data.append(message("A", struct.pack("<BH", topic.instance, number) + topic.name.encode()))
        rows = [row for number, topic in enumerate(self.topics) for row in _samples(number, topic)]
        rows += [(round(time_s * 1e6), parameter(name, value)) for time_s, name, value in self.changes]
        return b"".join([*data, message("S", SYNC), *(row for _, row in sorted(rows, key=lambda row: row[0]))])


def message(kind: str, payload: bytes) -> bytes:
    """Return a message: length, letter, payload."""
    return struct.pack("<HB", len(payload), ord(kind)) + payload


def parameter(name: str, value: float) -> bytes:
    """Return the message of a parameter, int32 for a whole Python number."""
    kind, code = ("int32_t", "<i") if isinstance(value, int) else ("float", "<f")
    return message("P", _key(f"{kind} {name}") + struct.pack(code, value))


def vector(name: str, values: np.ndarray, kind: str = "float") -> dict[str, Value]:
    """Return a field that is an array."""
    return {name: (kind, np.asarray(values))}


def xyz(values: np.ndarray) -> dict[str, Value]:
    """Return the fields x, y, z."""
    return {axis: ("float", column) for axis, column in zip("xyz", np.asarray(values).T, strict=True)}


def _key(text: str) -> bytes:
    return bytes([len(text)]) + text.encode()


def _fields(topic: TopicOf) -> str:
    parts = ["uint64_t timestamp;"]
    for name, (kind, values) in topic.fields.items():
        length = f"[{np.shape(values)[1]}]" if np.ndim(values) == 2 else ""
        parts.append(f"{kind}{length} {name};")
    return "".join(parts) + (f"uint8_t[{topic.padding}] _padding0;" if topic.padding else "")


def _samples(number: int, topic: TopicOf) -> list[tuple[int, bytes]]:
    times_us = [round(float(time_s) * 1e6) for time_s in topic.time_s]
    columns = [
        (CODES[kind], np.asarray(values).reshape(len(times_us), -1).tolist()) for kind, values in topic.fields.values()
    ]
    found = []
    for k, time_us in enumerate(times_us):
        sample = struct.pack("<HQ", number, time_us)
        sample += b"".join(struct.pack(f"<{len(rows[k])}{code}", *rows[k]) for code, rows in columns)
        found.append((time_us, message("D", sample)))
    return found
