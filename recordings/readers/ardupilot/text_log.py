"""ArduPilot's DataFlash logs as text (.log), as ground stations convert or download them, by column.

A line is the type's name and its values, separated by commas; lines of FMT give number, length, name, format and the
names of the values of every type. Numbers are in their unit already: degrees, not 1e-7 degrees.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow import csv

from recordings.files import system_errors_about
from recordings.readers.ardupilot.index import CODES, SCALES, MessageLayout
from recordings.readers.ardupilot.messages import TEXTS, WHOLE, Dataflash, Messages
from scenarios.arrays import Array
from scenarios.errors import InputError

FORMAT_LINE = re.compile(rb"^(?:\xef\xbb\xbf)?[ \t]*FMT *, *\d+ *, *\d+ *, *\w+ *, *\w+ *,", re.MULTILINE)
"""A line that lays out a type."""
MOST_BYTES, MOST_LINES = 150_000_000, 1_200_000
"""Longest log that is read; memory stays below 1 GB."""
MOST_KINDS, MOST_ROW_BYTES = 16, 300_000_000
"""Values of a message, by the format of the binary log, and bytes of a type's rows beyond which it is not read."""
CHUNK = 20_000
"""Lines that are taken apart at a time."""
MOST_TYPES = 256
TEXT_BYTES = 80
"""Longest text of a message that is kept."""
LARGEST_BYTE = 255
"""Values of one byte beyond this are damage."""
_NAME = re.compile(rb" *(\w{1,4}) *,", re.ASCII)
Lines = list[tuple[int, bytes]]


def is_text_log(head: bytes) -> bool:
    """Whether the first bytes of a file hold a line that lays out a message type."""
    return FORMAT_LINE.search(head) is not None


def read_text_log(path: Path) -> Dataflash:
    """Return the messages of a log as text; InputError for a log without a whole message, and for one too long."""
    with system_errors_about(path, "check the path and the permissions"):
        if path.stat().st_size > MOST_BYTES:
            raise _too_long(path)
        by_type, stray = _lines_by_type(path)
    layouts = _layouts(by_type.pop(b"FMT", []))
    types: dict[str, Messages] = {}
    order: dict[str, Array] = {}
    for name, layout in layouts.items():
        lines = by_type.pop(name.encode(), [])
        numbers, rows = _rows(lines, layout)
        if len(rows):
            length = sum(len(line) for _, line in lines) // len(lines)
            types[name] = _messages(replace(layout, length=length), rows)
            order[name] = numbers
            stray += length * (len(lines) - len(rows))
    stray += sum(len(line) for lines in by_type.values() for _, line in lines)
    if not types:
        raise InputError("holds no whole message of ArduPilot", where=str(path), do="convert the log again")
    return Dataflash(_timed(types, order), stray)


def _lines_by_type(path: Path) -> tuple[dict[bytes, Lines], int]:
    """Return the lines of each type with their numbers, without the name, and the bytes of other lines."""
    found: dict[bytes, Lines] = {}
    stray = 0
    with path.open("rb") as file:
        for number, line in enumerate(file):
            if number >= MOST_LINES:
                raise _too_long(path)
            match = _NAME.match(line.removeprefix(b"\xef\xbb\xbf"))
            if match:
                found.setdefault(match[1], []).append((number, line[line.index(b",") + 1 :].rstrip(b"\r\n")))
            else:
                stray += len(line.strip())
    return found, stray


def _too_long(path: Path) -> InputError:
    what = f"is a log as text of more than {MOST_BYTES // 1_000_000} MB or {MOST_LINES} lines"
    return InputError(what, where=str(path), do="give the .bin log that the text was made of")


def _layouts(lines: Lines) -> dict[str, MessageLayout]:
    """Return the layout of each type; the first of two definitions counts."""
    found: dict[str, MessageLayout] = {}
    for _, line in lines:
        parts = [part.strip() for part in line.decode("ascii", "replace").split(",")]
        if len(parts) > 4 and parts[2] != "FMT" and parts[2] not in found and len(found) < MOST_TYPES:
            found |= _layout_of(parts[2], parts[3], parts[4:])
    return found


def _layout_of(name: str, kinds: str, names: Sequence[str]) -> dict[str, MessageLayout]:
    """Return the layout by the type's name; none of a line that contradicts itself."""
    own = dict(zip(names, kinds, strict=False))
    usable = 0 < len(kinds) <= MOST_KINDS and set(kinds) <= set(CODES)
    return {name: _layout(name, own)} if usable and len(own) == len(kinds) and all(own) else {}


def _layout(name: str, kinds: Mapping[str, str]) -> MessageLayout:
    """Return the layout of a type whose numbers are in their unit, texts as bytes."""
    own = {field: "d" if kind in SCALES else kind for field, kind in kinds.items()}
    own |= {field: "N" for field, kind in kinds.items() if kind == "M" and field == "Mode"}
    formats = [f"S{TEXT_BYTES}" if kind in TEXTS + "a" else "f8" for kind in own.values()]
    return MessageLayout(name, 0, own, np.dtype({"names": list(own), "formats": formats}))


def _rows(lines: Lines, layout: MessageLayout) -> tuple[Array, NDArray[Any]]:
    """Return the numbers of the lines (n,) that are whole, and their values as a structured array (n,)."""
    count = len(layout.kinds)
    whole = [(number, line) for number, line in lines if line.count(b",") >= count - 1]
    if len(whole) * layout.dtype.itemsize > MOST_ROW_BYTES:
        whole = []
    rows = np.zeros(len(whole), layout.dtype)
    for first in range(0, len(whole), CHUNK):
        split = (line.split(b",", count - 1) for _, line in whole[first : first + CHUNK])
        _fill(rows[first : first + CHUNK], layout, zip(*split, strict=True))
    sound = _are_sound(rows, layout)
    return np.array([number for number, _ in whole], np.float64)[sound], rows[sound]


def _fill(rows: NDArray[Any], layout: MessageLayout, columns: Iterable[Sequence[bytes]]) -> None:
    """Write columns of texts (n,) into the rows (n,)."""
    for (field, kind), column in zip(layout.kinds.items(), columns, strict=True):
        rows[field] = [text.strip() for text in column] if kind in TEXTS + "a" else _numbers(column)


def _numbers(column: Sequence[bytes]) -> Array:
    """Return texts as numbers (n,), NaN for a text that is none."""
    options = csv.ConvertOptions(column_types={"x": pa.float64()}, null_values=["", "nan", "NaN", "-nan"])
    reading = csv.ReadOptions(column_names=["x"])
    try:
        text = io.BytesIO(b"\n".join(column) + b"\n")
        found = csv.read_csv(text, reading, csv.ParseOptions(ignore_empty_lines=False), options)["x"].to_numpy()
    except pa.ArrowInvalid:
        found = np.empty(0)
    return found if len(found) == len(column) else np.array([_number(text) for text in column])


def _number(text: bytes) -> float:
    try:
        return float(text)
    except ValueError:
        return np.nan


def _are_sound(rows: NDArray[Any], layout: MessageLayout) -> NDArray[np.bool_]:
    """Return the rows (n,) whose whole numbers are numbers, those of a byte in its range."""
    sound = np.ones(len(rows), np.bool_)
    for field, kind in layout.kinds.items():
        if kind in WHOLE:
            sound &= np.isfinite(rows[field])
        if kind in "bB":
            sound &= np.abs(rows[field]) <= LARGEST_BYTE
    return sound


def _messages(layout: MessageLayout, rows: NDArray[Any]) -> Messages:
    return Messages(layout, rows, np.arange(len(rows)))


def _timed(types: dict[str, Messages], order: Mapping[str, Array]) -> dict[str, Messages]:
    """Return the messages, those of types without a clock with the times of the lines around them."""
    timed = max(types, key=lambda name: len(types[name]) if types[name].clock[0] else 0)
    clock, unit_s = types[timed].clock
    without = [name for name, rows in types.items() if not rows.clock[0]] if clock else []
    for name in without:
        times_us = np.interp(order[name], order[timed], types[timed].numbers(clock) * unit_s * 1e6)
        types[name] = _with_clock(types[name], times_us)
    return types


def _with_clock(messages: Messages, times_us: Array) -> Messages:
    """Return messages with a time of writing."""
    names = list(messages.layout.kinds)
    formats = [messages.view.dtype[name] for name in names]
    dtype = np.dtype({"names": [*names, "TimeUS"], "formats": [*formats, np.dtype("f8")]})
    rows = np.zeros(len(messages), dtype)
    for name in names:
        rows[name] = messages.view[name]
    rows["TimeUS"] = times_us
    return _messages(replace(messages.layout, kinds=messages.layout.kinds | {"TimeUS": "Q"}, dtype=dtype), rows)
