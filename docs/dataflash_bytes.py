"""DataFlash logs laid out byte by byte, by ArduPilot's specification of the format: for the docs' log and for tests."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from scenarios.arrays import Array

CODES = {
    **{"b": "b", "B": "B", "h": "h", "H": "H", "i": "i", "I": "I", "f": "f", "d": "d", "q": "q", "Q": "Q", "M": "B"},
    **{"n": "4s", "N": "16s", "Z": "64s", "c": "h", "C": "H", "e": "i", "E": "I", "L": "i"},
}
FIXED = {"c": 100, "C": 100, "e": 100, "E": 100, "L": 10_000_000}
"""Counts in a unit."""
HEAD = b"\xa3\x95"
DOWN = np.array([1.0, -1.0, -1.0])


@dataclass
class Log:
    """Messages in the order of their times; a type is laid out by the first message of its name."""

    layouts: dict[str, tuple[int, str, str]] = field(default_factory=dict)
    messages: list[tuple[float, bytes]] = field(default_factory=list)

    def layout(self, name: str, form: str, columns: str) -> None:
        """Lay out a type, numbered from 130."""
        self.layouts[name] = (130 + len(self.layouts), form, columns)

    def add(self, name: str, time_s: float, *values: float | str) -> None:
        """Write a message; the time in the unit of the first column comes first, unless the type has no time."""
        number, form, columns = self.layouts[name]
        clock = columns.split(",")[0]
        timed = {"TimeUS": [round(time_s * 1e6)], "TimeMS": [round(time_s * 1e3)]}.get(clock, [])
        packed = [_packed(kind, value) for kind, value in zip(form, [*timed, *values], strict=True)]
        self.messages.append((time_s, HEAD + bytes([number]) + b"".join(packed)))

    def rows(self, name: str, times_s: Array, *columns: Array | float) -> None:
        """Write a message for each time."""
        full = np.broadcast_arrays(*columns, np.zeros(len(times_s)))[:-1]
        for time_s, *values in zip(times_s, *full, strict=True):
            self.add(name, float(time_s), *(float(value) for value in values))

    def parameters(self, time_s: float, **values: float) -> None:
        """Write PARM messages."""
        if "PARM" not in self.layouts:
            self.layout("PARM", "QNff", "TimeUS,Name,Value,Default")
        for name, value in values.items():
            self.add("PARM", time_s, name, value, 0.0)

    def data(self) -> bytes:
        """The whole log: the layouts, then the messages by time."""
        layouts = {"FMT": (0x80, "BBnNZ", "Type,Length,Name,Format,Columns")} | self.layouts
        heads = [
            HEAD
            + bytes([0x80])
            + struct.pack("<BB4s16s64s", number, 3 + _size(form), name.encode(), form.encode(), columns.encode())
            for name, (number, form, columns) in layouts.items()
        ]
        return b"".join([*heads, *(message for _, message in sorted(self.messages, key=lambda one: one[0]))])

    def write(self, path: Path) -> Path:
        """Write the log to a file."""
        path.write_bytes(self.data())
        return path


def _size(form: str) -> int:
    return struct.calcsize("<" + "".join(CODES[kind] for kind in form))


def _packed(kind: str, value: float | str) -> bytes:
    if isinstance(value, str):
        return struct.pack("<" + CODES[kind], value.encode())
    if kind in "fd":
        return struct.pack("<" + CODES[kind], value)
    return struct.pack("<" + CODES[kind], int(round(value * FIXED[kind]) if kind in FIXED else value))


def write_compass(log: Log, at_s: Array, field_nT: Array, instance: int = 0, **more: Array | float) -> None:
    """Write MAG messages of a field (n, 3) in FLU: in FRD, cut toward zero to whole mG as C does."""
    if "MAG" not in log.layouts:
        log.layout("MAG", "QBhhhhhhhhhBI", "TimeUS,I,MagX,MagY,MagZ,OfsX,OfsY,OfsZ,MOX,MOY,MOZ,Health,S")
    whole = [np.trunc(np.broadcast_to(more.get(name, 0.0), (len(at_s), 3))).T for name in ("offset_mG", "motor_mG")]
    field_mG = np.trunc(field_nT * DOWN / 100)
    sampled_s = more.get("sampled_s", at_s)
    stamp = np.mod(np.round(np.asarray(sampled_s) * 1e6), 2.0**32)
    log.rows("MAG", at_s, instance, *field_mG.T, *whole[0], *whole[1], more.get("health", 1.0), stamp)
