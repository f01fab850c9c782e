"""ULog, the container of PX4's logs: topics as columns, parameters with their changes.

The file is a header and messages of a length, a letter and a payload; F describes a topic's bytes, A gives a topic a
number, D is a topic's sample under this number, P a parameter [docs.px4.io, ULog File Format].
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.files import system_errors_about
from recordings.readers.px4.contents import Bytes, ParameterChange, ULog, UlogTopic
from recordings.readers.px4.formats import TopicLayout, UnreadableFormatError, layout_of
from scenarios.errors import InputError

MAGIC = b"ULog\x01\x12\x35"
HEADER_BYTES = 16
MOST_TOPIC_FIELDS = 200_000
"""Fields of all topics together beyond which further topics are not read; PX4's logs have below 10,000."""
MOST_TOPICS, MOST_PARAMETERS, MOST_CHANGES, MOST_DAMAGES = 5_000, 20_000, 10_000, 20_000
"""Limits of what is kept of a file and of the damaged stretches that are skipped; PX4's logs have a tenth of these."""
MOST_OTHERS = 1_000_000
"""Messages that are no samples of a topic beyond which a file is no log; PX4's logs have below 100,000."""
_HEAD = struct.Struct("<HBH")
_FLAGS = struct.Struct("<8s8s3Q")
SAMPLE = b"D"[0]
"""The letter of a topic's sample."""
_APPENDED = 1
"""The first bit of the incompatible flags: data were appended after a crash, at the three offsets."""


def read_ulog(path: Path) -> ULog:
    """Return what a ULog file holds; damaged stretches are skipped and counted.

    Raises InputError for a file that is no ULog, and for features beyond this reader.
    """
    with system_errors_about(path, "check the path and the permissions"):
        data: Bytes = np.memmap(path, np.uint8, mode="r")
    if bytes(data[: len(MAGIC)]) != MAGIC or len(data) <= HEADER_BYTES:
        raise InputError("is no ULog, or cut off in its header", where=str(path), do="copy the log again")
    return _MessageReader(path, data, _ends(path, data)).read()


def _ends(path: Path, data: Bytes) -> list[int]:
    """Return the ends of the stretches of messages: where data were appended, and the file's end."""
    first = bytes(data[HEADER_BYTES : HEADER_BYTES + 3 + _FLAGS.size])
    if len(first) < 3 + _FLAGS.size or first[2:3] != b"B":
        return [len(data)]
    _, incompatible, *offsets = _FLAGS.unpack_from(first, 3)
    if incompatible[0] & ~_APPENDED or any(incompatible[1:]):
        do = "give a log of a known PX4 release, or copy the log again"
        raise InputError("is a ULog with features that are not known here", where=str(path), do=do)
    appended = [offset for offset in offsets if HEADER_BYTES < offset < len(data)] if incompatible[0] else []
    return [*sorted(appended), len(data)]


class _MessageReader:
    """One pass over the messages of a file."""

    def __init__(self, path: Path, data: Bytes, ends: list[int]) -> None:
        self.path = path
        self.data = data
        self.buffer = memoryview(data)  # type: ignore[arg-type]
        self.ends = ends
        self.log = ULog()
        self.formats: dict[str, str] = {}
        self.layouts: dict[str, TopicLayout | None] = {}
        self.topics: dict[int, UlogTopic] = {}
        self.every: list[UlogTopic] = []
        self.fields = self.damages = self.others = 0
        self.begun = False
        self.shortest = np.full(1 << 16, 1 << 16)
        self.longest = np.zeros(1 << 16, np.int64)
        self.last: UlogTopic | None = None
        self.read_payload = {
            b"F"[0]: self._format,
            b"A"[0]: self._add,
            b"P"[0]: self._parameter,
            b"I"[0]: self._information,
            **dict.fromkeys(b"BMQRLCSO", _ignored),
        }

    def read(self) -> ULog:
        """Return the log of all messages."""
        at = HEADER_BYTES
        for end in self.ends:
            at = max(at, self._stretch(at, end))
            self.log.cut = at < end and end == self.ends[-1]
            at = end
        for topic in self.every:
            key = (topic.name, topic.instance)
            if len(topic) and len(topic) > len(self.log.topics.get(key, ())):
                self.log.topics[key] = topic
        return self.log

    def _stretch(self, at: int, end: int) -> int:
        """Read messages from an offset on; return the offset behind the last whole message."""
        while at + _HEAD.size <= end:
            size, kind, number = _HEAD.unpack_from(self.buffer, at)
            after = at + 3 + size
            topic = self.topics.get(number) if kind == SAMPLE else None
            if topic is not None:
                good = topic.layout.size <= size - 2 <= topic.layout.padded
                if good and after <= end:
                    topic.at.append(at + 5)
                    self.last = topic
            else:
                good = self._other(kind, at + 3, after, end)
            if good and after > end:
                return at
            at = after if good else self._resumed(at, end)
        return at

    def _other(self, kind: int, at: int, after: int, end: int) -> bool:
        """Read a message that is no sample of a known topic; return whether it can be one."""
        self.others += 1
        if self.others > MOST_OTHERS:
            what = f"holds more than {MOST_OTHERS} messages that are no samples"
            raise InputError(what, where=str(self.path), do="copy the log again")
        if after == at or kind not in self.read_payload:
            return False
        return after > end or self.read_payload[kind](bytes(self.data[at:after]))

    def _resumed(self, at: int, end: int) -> int:
        """Return the offset of the next sample of a known topic behind a damaged stretch, else the end."""
        self.damages += 1
        rest = self.data[at + 1 : end if self.damages < MOST_DAMAGES else at + 1]
        found = next(_samples(rest, self.shortest, self.longest), end - at - 1)
        self.log.damaged += 1 + found
        return at + 1 + found

    def _format(self, payload: bytes) -> bool:
        """Keep a format's text; a topic that is used before keeps its format."""
        name, colon, fields = payload.decode("ascii", "replace").partition(":")
        self.formats[name] = fields
        return bool(colon)

    def _add(self, payload: bytes) -> bool:
        """Give a topic its number; a topic without a usable format keeps none."""
        self.begun = True
        if len(payload) < 4:
            return False
        name = payload[3:].decode("ascii", "replace")
        number = int.from_bytes(payload[1:3], "little")
        layout = self._layout(name)
        if layout is None or len(self.every) >= MOST_TOPICS:
            return True
        topic = UlogTopic(name, payload[0], layout, self.data)
        self.topics[number] = topic
        self.every.append(topic)
        self.shortest[number], self.longest[number] = layout.size + 2, layout.padded + 2
        return True

    def _layout(self, name: str) -> TopicLayout | None:
        """Return a topic's layout, None beyond the limits; a layout is made once."""
        if name not in self.layouts:
            try:
                found = layout_of(name, self.formats) if self.fields < MOST_TOPIC_FIELDS else None
            except UnreadableFormatError:
                found = None
            self.layouts[name] = found
            self.fields += len(found.dtype.names or ()) if found else 0
        return self.layouts[name]

    def _parameter(self, payload: bytes) -> bool:
        """Keep a parameter's value: an int32 or a float."""
        key, value = _key_and_value(payload)
        code = {"float": "<f", "int32_t": "<i"}.get(key[0])
        if code is None or len(value) != 4:
            return False
        number = float(struct.unpack(code, value)[0])
        if self.begun and len(self.log.changes) < MOST_CHANGES:
            self.log.changes.append(ParameterChange(self._now_s(), key[1], number))
        elif not self.begun and len(self.log.parameters) < MOST_PARAMETERS:
            self.log.parameters[key[1]] = number
        return True

    def _information(self, payload: bytes) -> bool:
        key, value = _key_and_value(payload)
        if key == ("uint32_t", "ver_sw_release") and len(value) == 4:
            self.log.release = ".".join(str(part) for part in value[:0:-1])
        return True

    def _now_s(self) -> float:
        """Return the time of the last sample, minus infinity before the first."""
        if self.last is None:
            return -np.inf
        at = self.last.at[-1] + self.last.layout.dtype.fields["timestamp"][1]  # type: ignore[index]
        return float(int.from_bytes(bytes(self.data[at : at + 8]), "little") * 1e-6)


def _ignored(payload: bytes) -> bool:
    return True


def _key_and_value(payload: bytes) -> tuple[tuple[str, str], bytes]:
    """Return (type, name) and the bytes of the value, of a message of an information or a parameter."""
    end = 1 + payload[0]
    kind, _, name = payload[1:end].decode("ascii", "replace").partition(" ")
    return (kind, name), payload[end:]


def _samples(data: Bytes, shortest: NDArray[Any], longest: NDArray[Any]) -> Iterator[int]:
    """Yield offsets at which a D message of a known topic and a fitting length begins, in growing windows.

    shortest, longest : by the topic's number, of the message.
    """
    start, width = 0, 256
    while start + _HEAD.size <= len(data):
        window = data[start : start + width + _HEAD.size - 1].astype(np.int64)
        at = np.flatnonzero(window[2:-2] == SAMPLE)
        size, number = (window[at + k] + 256 * window[at + k + 1] for k in (0, 3))
        yield from (start + at[(shortest[number] <= size) & (size <= longest[number])]).tolist()
        start, width = start + width, min(2 * width, 1 << 20)
