"""The frames of a MAVLink telemetry log, by sender and message, as numpy columns.

A frame is the receiver's time (us since 1970, 64 bits, big-endian), FE or FD for version 1 or 2, the payload's length,
the sender, the message's number, the payload, of which version 2 leaves out zeros at the end, and a checksum
[mavlink.io: serialization]. Layouts of messages are pymavlink's.
"""

from __future__ import annotations

import itertools
import re
from array import array
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array

Bytes = NDArray[np.uint8]
STAMP_BYTES = 8
FIRST, SECOND = 0xFE, 0xFD
HEADS = {FIRST: 6, SECOND: 10}
"""Bytes of the head, by the byte with which a frame of either version begins."""
CHECKSUM_BYTES = 2
SIGNED, SIGNATURE_BYTES = 0x01, 13
"""The flag of a signed frame of version 2, and the length of its signature."""
EARLIEST_US, LATEST_US = 9.0e14, 4.2e15
"""Stamps from 1998 to 2103; others are none of a receiver's."""
_MAGIC = re.compile(rb"[\xfe\xfd]")
_PARTS = re.compile(r"(\d*)([a-zA-Z])")


@dataclass(frozen=True, eq=False)
class Frames:
    """The payloads of one message of one sender.

    Parameters
    ----------
    name : of the message. stamps_s : (n,) the receiver's times, s since 1970. rows : (n,) payloads by field.
    instance : the field that tells sensors of one kind apart, "" where there is none.
    """

    name: str
    stamps_s: Array
    rows: NDArray[np.void]
    instance: str = ""

    def __len__(self) -> int:
        """The number of frames."""
        return len(self.rows)

    def __contains__(self, field: str) -> bool:
        """Whether the message has a field of this name."""
        return field in (self.rows.dtype.names or ())

    def numbers(self, field: str) -> Array:
        """Return a field of every frame: (n,), or (n, k) for an array."""
        return self.rows[field].astype(np.float64)

    def vector(self, *fields: str) -> Array:
        """Return several fields of every frame: (n, k)."""
        return np.column_stack([self.numbers(field) for field in fields])

    def words(self, field: str) -> list[str]:
        """Return a text of every frame."""
        return [bytes(word).split(b"\0")[0].decode("latin-1") for word in self.rows[field].tolist()]

    def where(self, chosen: NDArray[np.bool_]) -> Frames:
        """Return the frames that are chosen (n,)."""
        return Frames(self.name, self.stamps_s[chosen], self.rows[chosen], self.instance)


Place = tuple[int, int, int, int, int, int]
"""Start of the stamp, start of the payload, system, component, message, length of the payload."""
MOST_AT_ONCE = 500_000
"""Frames that are decoded at once, which bounds the memory of a file full of damaged ones."""
Places = NDArray[np.signedinteger[Any]]
"""Rows of Place (n, 6)."""
Sender = tuple[int, int]
"""The numbers of a system and of a component of the system."""


def frames_of(data: Bytes, messages: Mapping[int, Any]) -> tuple[dict[Sender, dict[str, Frames]], int]:
    """Return the sound frames by sender and name of the message, and the number of damaged frames.

    messages : by its number, a message as pymavlink describes it.
    """
    narrow = len(data) < 2**31  # half the memory: a frame may have 17 bytes
    numbers = array("i" if narrow else "q", itertools.chain.from_iterable(_places(data)))
    flat: Places = np.frombuffer(numbers, np.int32) if narrow else np.frombuffer(numbers, np.int64)
    places = flat.reshape(-1, 6)
    found: dict[Sender, dict[str, Frames]] = {}
    damaged = 0
    keys = places[:, 2] << 8 | places[:, 3]
    keys = keys.astype(np.int64) << 24 | places[:, 4]  # one number, as rows of three would be copied and sorted
    for key in np.unique(keys).tolist():
        system, component, number = key >> 32, key >> 24 & 0xFF, key & 0xFFFFFF
        if number in messages:
            own = places[keys == key]
            frames = _in_parts(data, own, messages[number])
            damaged += len(own) - len(frames)
            if len(frames):
                found.setdefault((system, component), {})[frames.name] = frames
    return found, damaged


def _places(data: Bytes) -> Iterator[Place]:
    """Yield every frame's place.

    A frame follows the last one; where none does, the next place counts at which a frame ends before another or at the
    end of the file.
    """
    raw, start = data.tobytes(), 0
    while start >= 0:
        place = _frame(raw, start)
        if place is None:
            start = _next(raw, start)
        else:
            yield place
            start = _end(raw, place)


def _frame(raw: bytes, start: int) -> Place | None:
    """Return the frame whose stamp begins at `start`; None where no whole frame begins."""
    at = start + STAMP_BYTES
    head = HEADS.get(raw[at], 0) if at < len(raw) else 0
    if not head or at + head > len(raw):
        return None
    if raw[at] == SECOND:
        number = int.from_bytes(raw[at + 7 : at + 10], "little")
        place = (start, at + head, raw[at + 5], raw[at + 6], number, raw[at + 1])
    else:
        place = (start, at + head, raw[at + 3], raw[at + 4], raw[at + 5], raw[at + 1])
    following = _end(raw, place) + STAMP_BYTES
    sound = following - STAMP_BYTES <= len(raw) and (following >= len(raw) or raw[following] in HEADS)
    return place if sound else None


def _end(raw: bytes, place: Place) -> int:
    """Return where a frame ends, with its checksum and signature."""
    at = place[0] + STAMP_BYTES
    signed = raw[at] == SECOND and raw[at + 2] & SIGNED
    return place[1] + place[5] + CHECKSUM_BYTES + (SIGNATURE_BYTES if signed else 0)


def _next(raw: bytes, start: int) -> int:
    """Return the next start of a stamp whose frame may be whole, -1 at the end of the file."""
    found = _MAGIC.search(raw, start + STAMP_BYTES + 1)
    return found.start() - STAMP_BYTES if found else -1


def _in_parts(data: Bytes, places: Places, message: Any) -> Frames:
    """Return the sound frames of one message, decoded MOST_AT_ONCE at a time."""
    starts = range(0, len(places), MOST_AT_ONCE)
    parts = [_decoded(data, places[start : start + MOST_AT_ONCE], message) for start in starts]
    stamps_s, rows = (np.concatenate([getattr(part, name) for part in parts]) for name in ("stamps_s", "rows"))
    return Frames(parts[0].name, stamps_s, rows, parts[0].instance)


def _decoded(data: Bytes, places: Places, message: Any) -> Frames:
    """Return the frames of one message whose checksum and stamp are right."""
    dtype = payload_dtype(message)
    payloads = np.zeros((len(places), dtype.itemsize), np.uint8)
    stamps_us = np.zeros(len(places))
    shapes = np.column_stack([places[:, 1] - places[:, 0], places[:, 5]])
    for before, length in np.unique(shapes, axis=0).tolist():
        own = np.flatnonzero(np.all(shapes == (before, length), axis=1))
        whole = _windows(data, places[own, 0], before + length + CHECKSUM_BYTES)
        sound = checksum(whole[:, STAMP_BYTES + 1 : -2], message.crc_extra) == _number(whole[:, -2:], "<u2")
        kept = min(length, dtype.itemsize)
        payloads[own, :kept] = whole[:, before : before + kept]
        stamps_us[own] = np.where(sound, _number(whole[:, :STAMP_BYTES], ">u8"), np.nan)
    frames = Frames(message.msgname, stamps_us * 1e-6, payloads.view(dtype)[:, 0], message.instance_field or "")
    return frames.where((stamps_us > EARLIEST_US) & (stamps_us < LATEST_US))


def _number(columns: Bytes, kind: str) -> NDArray[Any]:
    """Return numbers (n,) of their bytes (n, k)."""
    return np.ascontiguousarray(columns).view(kind)[:, 0]


def _windows(data: Bytes, starts: NDArray[Any], length: int) -> Bytes:
    """Return `length` bytes from each start: (n, length)."""
    return np.asarray(np.lib.stride_tricks.sliding_window_view(data, length)[starts])


def payload_dtype(message: Any) -> np.dtype[np.void]:
    """Return numpy's type of a message's whole payload, in the order of the bytes."""
    parts = _PARTS.findall(message.unpacker.format)
    return np.dtype([(n, _field(c, k)) for n, (k, c) in zip(message.ordered_fieldnames, parts, strict=True)])


def _field(code: str, count: str) -> np.dtype[Any]:
    if code in "sc":
        return np.dtype(f"S{count or 1}")
    single = np.dtype("<" + code)
    return np.dtype((single, (int(count),))) if count else single


def checksum(covered: Bytes, extra: int) -> NDArray[np.uint16]:
    """Return CRC-16/MCRF4XX of rows (n, k) and the message's extra byte: (n,)."""
    crc = np.full(len(covered), 0xFFFF, np.uint16)
    for column in (*covered.T, np.full(len(covered), extra, np.uint8)):
        crc = (crc >> 8) ^ _TABLE[(crc ^ column) & 0xFF]
    return crc


def _table() -> NDArray[np.uint16]:
    """Return the checksum's step for each byte: 8 divisions by the reflected polynomial 8408."""
    crc = np.arange(256, dtype=np.uint16)
    for _ in range(8):
        crc = np.where(crc & 1, (crc >> 1) ^ 0x8408, crc >> 1).astype(np.uint16)
    return crc


_TABLE = _table()
