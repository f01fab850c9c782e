"""A blackbox log's frames as columns: main frames at new readings of the magnetometer, slow states, fixes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from recordings.readers.blackbox import kernel
from recordings.readers.blackbox.header import MAGNETOMETER, Header, read_header
from recordings.readers.blackbox.kernel import GPS_ROWS, ROWS, SLOW_ROWS
from recordings.streams import Values
from scenarios.arrays import Array

MOST_CELLS = 30_000_000
"""Values that are kept of a log: 240 MB, and two hours of 60 fields at 70 Hz."""
BLOCK = 1 << 14
"""Rows that are decoded at a time."""


@dataclass(frozen=True, eq=False)
class FramesOfKind:
    """The frames of a kind: times in s (n,), and the fields by name (n,), as whole numbers."""

    times_s: Array
    columns: Mapping[str, Values]

    def vector(self, name: str, count: int = 3) -> Array | None:
        """Return fields name[0], name[1], ... as (n, count); None where one is missing."""
        names = [f"{name}[{k}]" for k in range(count)]
        if not all(one in self.columns for one in names):
            return None
        return np.column_stack([self.columns[one].astype(np.float64) for one in names])


@dataclass(frozen=True, eq=False)
class DecodedLog:
    """A log decoded: its header, main frames, slow states and fixes, and a line for each loss."""

    header: Header
    main: FramesOfKind
    slow: FramesOfKind
    fixes: FramesOfKind
    notes: tuple[str, ...]


def decoded_log(path: Path, data: bytes) -> DecodedLog:
    """Decode the log that begins at the first byte of `data`.

    Raises InputError for a header that cannot be used; frames that are damaged are left out and counted.
    """
    header, start = read_header(path, data)
    reading = _Reading(header, data, start)
    reading.run()
    return DecodedLog(header, reading.frames("I"), reading.frames("S"), reading.frames("G"), tuple(reading.notes()))


class _Reading:
    """The decoder's tables and what was decoded so far, in blocks of rows."""

    def __init__(self, header: Header, data: bytes, start: int) -> None:
        self.header = header
        self.data = np.frombuffer(data + bytes(kernel.LONGEST_FRAME), np.uint8)
        self.end = len(data)
        self.width = max(len(one.names) for one in header.frames.values())
        self.table, self.counts = _table(header, self.width)
        self.state = kernel.new_state()
        self.state[kernel.POSITION] = start
        self.blocks: dict[str, list[kernel.Integers]] = {"I": [], "S": [], "G": []}
        self.cut = False

    def run(self) -> None:
        """Decode until the data ends, or MOST_CELLS are there."""
        names = self.header.frames["I"].names
        watched = np.array([names.index(one) for one in MAGNETOMETER], np.int64)
        constants, history = self.header.constants(), np.zeros((5, self.width), np.int64)
        kept = 0
        while self.state[kernel.POSITION] < self.end and not self.state[kernel.ENDED] and not self.cut:
            rows = [np.zeros((BLOCK, self.width + 1), np.int64) for _ in self.blocks]
            self.state[[ROWS, SLOW_ROWS, GPS_ROWS]] = 0
            fixed = self.table, self.counts, constants, names.index("time"), watched
            kernel.decode(self.data, self.end, *fixed, self.state, history, *rows)
            counts = self.state[[ROWS, SLOW_ROWS, GPS_ROWS]]
            for (letter, blocks), row, count in zip(self.blocks.items(), rows, counts, strict=True):
                blocks.append(row[:count, : self._count(letter) + 1].copy())
                kept += blocks[-1].size
            self.cut = kept > MOST_CELLS

    def _count(self, letter: str) -> int:
        frame = self.header.frames.get(letter)
        return len(frame.names) if frame else 0

    def frames(self, letter: str) -> FramesOfKind:
        """Return the frames of a kind."""
        frame = self.header.frames.get(letter)
        none = np.zeros((0, 1 + (len(frame.names) if frame else 0)), np.int64)
        values = np.concatenate(self.blocks[letter]) if self.blocks[letter] else none
        columns = dict(zip(frame.names, values[:, 1:].T, strict=True)) if frame else {}
        return FramesOfKind(values[:, 0].astype(np.float64) * 1e-6, columns)

    def notes(self) -> list[str]:
        """Return a line for each loss."""
        wrong, ended = int(self.state[kernel.WRONG]), bool(self.state[kernel.ENDED])
        lines = [f"{wrong} damaged frames left out"] if wrong else []
        if self.cut:
            return [*lines, "the log is longer than what is read at once: its end is left out"]
        return lines if ended else [*lines, "the log has no end mark: the controller lost power, or it is cut off"]


def _table(header: Header, width: int) -> tuple[kernel.Integers, kernel.Integers]:
    """Return encodings, predictors and signs (5, 3, width) of the frames of `kernel.MARKERS`, and their fields (5,)."""
    table, counts = np.zeros((5, 3, width), np.int64), np.zeros(5, np.int64)
    for k, letter in enumerate(kernel.MARKERS.decode()):
        if letter in header.frames:
            frame = header.frames[letter]
            counts[k] = len(frame.names)
            table[k, :, : counts[k]] = (frame.encodings, frame.predictors, frame.signed)
    return table, counts
