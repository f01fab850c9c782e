"""DataFlash logs as ground stations convert them to text: a line a message, numbers in their unit."""

from __future__ import annotations

import struct
from pathlib import Path

from dataflash_bytes import CODES, FIXED, HEAD, Log

from recordings import Recording
from tests.recordings.readers.dataflash import dataflash_of

MODES = {5: "Loiter", 16: "PosHold"}


def as_text(log: Log, separator: str = ", ") -> str:
    """The log's lines: the layouts first, then the messages in the order of their times."""
    by_number = {number: (name, form) for name, (number, form, _) in log.layouts.items()}
    lines = ["FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns"]
    for name, (number, form, columns) in log.layouts.items():
        size = 3 + struct.calcsize("<" + "".join(CODES[kind] for kind in form))
        lines.append(separator.join(["FMT", str(number), str(size), name, form, columns]))
    for _, data in sorted(log.messages, key=lambda one: one[0]):
        assert data.startswith(HEAD)
        name, form = by_number[data[2]]
        values = struct.unpack("<" + "".join(CODES[kind] for kind in form), data[3:])
        lines.append(separator.join([name, *map(_printed, form, values)]))
    return "\r\n".join(lines) + "\r\n"


def write_text(log: Log, path: Path, separator: str = ", ") -> Path:
    """Write a log as text."""
    path.write_text(as_text(log, separator), newline="")
    return path


def write_dataflash_text(recording: Recording, path: Path) -> None:
    """Write a recording as a log in text."""
    write_text(dataflash_of(recording), path)


def _printed(kind: str, value: object) -> str:
    if isinstance(value, bytes):
        return value.split(b"\0")[0].decode()
    assert isinstance(value, int | float)
    if kind == "M":
        return MODES.get(int(value), f"Mode({value})")
    if kind in FIXED:
        return repr(value / FIXED[kind])
    return repr(value)
